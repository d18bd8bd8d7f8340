"""Shallow ironing: a stiff rounded block is pressed into a soft foundation and drawn along it, mu = 0.3.

Geometry, laws and path are those of a benchmark that six codes have published forces of; there is no exact answer. They
spread over 24 % (vertical, end of press), 25 % (vertical, half-way) and a factor 1.8 (horizontal, half-way).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

PRESS, SLIDE = 1.0, 10.0
PUBLISHED = {"end of press": (267.9, 332.0), "vertical half-way": (337.4, 421.0), "horizontal half-way": (102.1, 188.8)}
"""Least and largest of Code_Aster, Hartmann, Fischer & Wriggers, Yastrebov, Poulios & Renard, solids4foam [N/mm]."""


def ironing(
    algorithm: str, swap: bool = False, level: int = 1, steps: int = 220, slide: float = SLIDE, **keys: Any
) -> Scene:
    """Foundation 12 x 4 under a block 1.2 wide with a rounded lower side (sagitta 0.3), 0.2 above it at the start."""
    hyperelastic = {"use": "neo-hookean", "poisson": 0.32, "density": 1.0}
    bodies = {
        "block": {
            "element": "q1",
            "material": "hard",
            "shift": [0.8, 0.2],
            "mesh": {"use": "arc-block", "radius": 0.75, "half_width": 0.6, "top": 1.2, "cells": [14, 12]},
        },
        "foundation": {
            "element": "q1",
            "material": "soft",
            "mesh": {"use": "rectangle", "x": [0.0, 12.0], "y": [-4.0, 0.0], "cells": [120, 30]},
        },
    }
    path = {
        "on": "block.top",
        "uy": {"ramp": "linear", "to": -PRESS, "duration": 1.0},
        "ux": {"ramp": "linear", "to": slide, "begin": 1.0, "duration": 1.0},
    }
    data = {
        "name": "shallow-ironing",
        "level": level,
        "time": {"end": 2.0},
        "integrator": {"use": "newton", "steps": steps},
        "materials": {"soft": hyperelastic | {"young": 689.6}, "hard": hyperelastic | {"young": 6896.0}},
        "bodies": bodies,
        "contacts": [
            {
                "slave": "block.arc",
                "master": "foundation.top",
                "algorithm": algorithm,
                "swap": swap,
                "friction": {"use": "coulomb", "mu": 0.3},
            }
        ],
        "supports": [{"on": "foundation.bottom", "ux": 0.0, "uy": 0.0}, path],
        "record": {"recorders": [], "frames": 2 * steps},
    }
    return Scene.from_data(data | keys)


@dataclass
class Forces:
    """Of the block on the foundation by the way of its top: down PRESS, then along [mm, N/mm]."""

    along: Floats
    vertical: Floats
    horizontal: Floats
    pressed: float
    iterations: int
    status: str


def forces(scene: Scene, slide: float = SLIDE) -> Forces:
    """Run the scene."""
    results = simulate(scene)
    time = np.asarray(results.history["time"])
    fx, fy = (np.asarray(results.history[f"block.top.{component}"]) for component in ("fx", "fy"))
    sliding = time >= 1.0
    pressed = float(np.interp(1.0, time, -fy))
    iterations = int(results.summary["iterations"])
    status = results.status if results.status == "finished" else f"{results.status}: {results.reason}"
    return Forces((time[sliding] - 1.0) * slide, -fy[sliding], fx[sliding], pressed, iterations, status)


def saw_tooth(along: Floats, force: Floats, size: float, start: float, end: float) -> float:
    """Largest distance of the force from its mean over two segments, as a fraction of it; start < along < end."""
    even = np.linspace(along[0], along[-1], 4 * len(along))
    values = np.interp(even, along, force)
    window = max(3, round(2.0 * size / float(even[1] - even[0])))
    smooth = np.convolve(values, np.full(window, 1.0 / window), mode="same")
    inside = (even > start) & (even < end)
    return float(np.abs(values - smooth)[inside].max() / np.abs(smooth[inside]).mean())
