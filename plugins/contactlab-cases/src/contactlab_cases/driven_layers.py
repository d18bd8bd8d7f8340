"""Two layers that slide on each other while a shear runs along with a wave between them.

Forces on both surfaces hold their pressure and shear, so that both layers are free of stress until a wave comes.
Modulus 1 MPa and density 1 t/mm3 of the upper layer, the wave and its shear wave's speed are 1 mm and 1 mm/s; nu = 0.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Floats, Job, Setup
from contactlab_cases.dynamics import WORK, strip
from contactlab_cases.interface_waves import driven_wave, sliding_wave

LENGTH, HEIGHT, END = 10.5, 2.5, 6.0  # mm, s
PRESSURE, SPEED = 1e-5, 1e-6  # MPa, mm/s: slides by less than a ten-thousandth of a cell in all
CELLS = 10  # in the wave, on the coarsest mesh
DRIVEN, PUSH, TICK = 3.0, 3e-3, 0.05  # periods; largest shear over the pressure; shear of the tick over it
WAVE_NUMBER = 2.0 * math.pi  # 1/mm


def layers_job(name: str, setup: Setup, cells: int, modulus: float, mu: float) -> Job:
    """A run with so many cells in the wave; the lower layer has another modulus."""
    law = {"use": "linear-elastic", "poisson": 0.0, "density": 1.0}
    n, x = [round(cells * LENGTH), round(cells * HEIGHT)], (0.0, LENGTH)
    held = {"tx": mu * PRESSURE, "ty": -PRESSURE}
    scene = {
        "name": name, "integrator": setup.integrator, "time": {"end": END, "fraction": 0.8},
        "materials": {"m": {**law, "young": 2.0}, "lower": {**law, "young": 2.0 * modulus}},
        "bodies": {
            "upper": strip(x, (0.0, HEIGHT), n, element=setup.element, velocity=[SPEED, 0.0]),
            "lower": strip(x, (-HEIGHT, 0.0), n, element=setup.element) | {"material": "lower"},
        },
        "contacts": [{
            "slave": "upper.bottom", "master": "lower.top", "algorithm": setup.algorithm, "swap": setup.swap,
            "friction": {"use": "coulomb", "mu": mu},
        }],
        "loads": [
            {"on": "upper.bottom", "follower": False, **held},
            {"on": "lower.top", "follower": False, **{key: -value for key, value in held.items()}},
            *_pushes(1.0 / cells, modulus, mu),
        ],
    }  # fmt: skip
    return Job(name, scene, watch=({"use": "nodal-forces", "every": max(1, cells // CELLS)},), work=WORK)


def _swell(modulus: float, mu: float) -> tuple[Floats, Floats, float]:
    """Times (n,) [s], envelope of the travelling shear, and its frequency [1/s]."""
    w = -sliding_wave(modulus, mu).imag * WAVE_NUMBER
    times = np.linspace(0.0, DRIVEN * 2.0 * math.pi / w, 121)
    return times, np.sin(np.pi * times / times[-1]) ** 2, w


def _pushes(h: float, modulus: float, mu: float) -> list[dict[str, Any]]:
    """cos(k x - w t) in an envelope, as two standing shears, and a tick on one node, of waves of all lengths."""
    times, swell, w = _swell(modulus, mu)
    x = np.linspace(0.5, 5.5, 251)
    hill = np.exp(-((x - 3.0) ** 2))
    tick = [0.0, TICK * (CELLS * h) ** 2, 0.0]  # on a finer mesh it grows faster
    parts = [
        *((times, swell * part(w * times), x, hill * part(WAVE_NUMBER * x)) for part in (np.cos, np.sin)),
        ([0.0, 0.1, 0.2], tick, [4.0 - h, 4.0, 4.0 + h], [0.0, 1.0, 0.0]),
    ]
    return [
        {
            "on": "upper.bottom", "follower": False,
            "tx": {"ramp": "table", "to": PUSH * PRESSURE, "points": np.transpose([t, in_time]).tolist()},
            "profile": {"by": "x", "table": np.transpose([at, along]).tolist()},
        }
        for t, in_time, at, along in parts
    ]  # fmt: skip


def exact_wave(times: Floats, modulus: float, mu: float) -> NDArray[np.complex128]:
    """(n,) what the shear that runs along makes of the pressure between half planes, up to a factor, at `times` [s]."""
    begun, swell, w = _swell(modulus, mu)
    even = np.linspace(0.0, 4.0 * END, 1024)
    shear = np.interp(even, begun, swell, right=0.0) * np.exp(-1j * w * even)
    wave = driven_wave(WAVE_NUMBER * even, shear, modulus, mu)
    return np.asarray(np.interp(times, even, wave.real) + 1j * np.interp(times, even, wave.imag))
