"""Rows of bars in one line, at Courant number 1: the mesh carries waves exactly but for the last cell of each bar.

At 1 itself the shortest wave grows with the number of steps, from what an impact leaves in it: long runs stay below.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from contactlab.api import Job, Setup
from contactlab_cases.dynamics import WORK
from contactlab_cases.series import series

LENGTH, SOUND = 10.0, 30.0  # m, m/s
HEIGHT = 0.4  # m


def bars_job(
    setup: Setup, cells: int, speeds: Sequence[float], densities: Sequence[float], gap: float, end: float,
    quantities: Sequence[str], watched: str = "bar1", courant: float = 1.0, **more: Any,
) -> Job:  # fmt: skip
    """Bars bar0, bar1 ... of `cells` each, `gap` steps of a unit speed apart; sound is as fast in all of them."""
    step = courant * LENGTH / cells / SOUND
    bodies, materials = {}, {}
    for k, (speed, density) in enumerate(zip(speeds, densities, strict=True)):
        law = {"use": "linear-elastic", "young": density * SOUND**2, "poisson": 0.0, "density": density}
        mesh = {"use": "rectangle", "x": [0.0, LENGTH], "y": [0.0, HEIGHT], "cells": [cells, 1]}
        materials[f"m{k}"] = law
        bodies[f"bar{k}"] = {
            "element": setup.element, "material": f"m{k}", "mesh": mesh, "velocity": [speed, 0.0],
            "shift": [k * LENGTH + (gap * step if k else 0.0), 0.0],
        }  # fmt: skip
    sides = {"algorithm": setup.algorithm, "swap": setup.swap}
    contacts: list[Mapping[str, Any]] = [
        {"slave": f"bar{k + 1}.left", "master": f"bar{k}.right"} | sides for k in range(len(speeds) - 1)
    ]
    scene = {
        "name": "bars", "units": "m N s kg", "time": {"end": end, "step": step}, "integrator": setup.integrator,
        "materials": materials, "bodies": bodies, "contacts": [*contacts, *more.pop("contacts", [])],
        "supports": [{"on": name, "uy": 0.0} for name in bodies],
    }  # fmt: skip
    kept = {"use": "leapfrog-energy", "name": "bars", "body": watched}
    return Job("hit", scene | more, watch=(kept, series(*quantities)), work=WORK)


def start_energy(speeds: Sequence[float], densities: Sequence[float]) -> float:
    """Kinetic energy [J] of the start."""
    return sum(0.5 * d * LENGTH * HEIGHT * v**2 for v, d in zip(speeds, densities, strict=True))
