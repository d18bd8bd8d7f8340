"""The longest explicit step that works, with contact and without, for every algorithm and element, by bisection.

    python benchmarks/studies/step_margins.py

A spinning disc hits another one off centre, or passes it. A step works where the kinetic energy is never more than a
tenth above that of the start. Steps are over the bound of the elements (docs/theory/contact-energy.md).
"""

from __future__ import annotations

import itertools
from typing import Any

import contactlab
from contactlab.errors import ContactlabError
from contactlab.model.build import build

LOW, HIGH, HALVINGS = 0.8, 3.2, 7
CELLS, END, SPEED = 6, 1e-4, 20000.0
ALGORITHMS = ("mortar-p0", "mortar-p1", "node-on-segment")


def scene(element: str, algorithm: str, forces: str, hits: bool) -> contactlab.Scene:
    """Two soft discs of radius 1 mm; the upper one turns and comes down, onto the other or beside it."""
    mesh = [{"use": "disc", "radius": 1.0, "cells": [cells, CELLS // 2]} for cells in (CELLS, CELLS + 1)]
    body: dict[str, Any] = {"element": element, "material": "soft"}
    return contactlab.Scene.from_data(
        {
            "format": 1, "name": "step-margins", "time": {"end": END}, "integrator": {"use": "central-difference"},
            "materials": {"soft": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
            "bodies": {
                "upper": body | {"mesh": mesh[0], "velocity": [0.0, -SPEED], "spin": 2e4},
                "lower": body | {"mesh": mesh[1], "shift": [0.3 if hits else 6.0, -2.02]},
            },
            "contacts": [{
                "slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm,
                "enforcement": {"use": "forward-increment", "forces": forces},
            }],
        }
    )  # fmt: skip


def works(tried: contactlab.Scene, fraction: float) -> bool:
    """Whether a run with this fraction of the bound keeps its energy."""
    model = build(tried, tried.registry)
    advance, dt, start = model.bound_integrator().step, fraction * model.stable_step(), model.kinetic_energy()
    while model.state.time < END:
        try:
            advance(dt)
        except ContactlabError:
            return False
        if not model.kinetic_energy() < 1.1 * start:
            return False
    return True


def margin(tried: contactlab.Scene) -> float:
    """The largest fraction that works, to within (HIGH - LOW) / 2^HALVINGS."""
    low, high = LOW, HIGH
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if works(tried, middle) else (low, middle)
    return low


def main() -> None:
    """Print the table."""
    print("| element | algorithm | forces | without contact | with contact |")
    print("|---|---|---|---|---|")
    for element in ("q1", "q2", "q2-lagrange"):
        free = margin(scene(element, ALGORITHMS[0], "frozen", False))
        for algorithm, forces in itertools.product(ALGORITHMS, ("frozen", "consistent")):
            found = margin(scene(element, algorithm, forces, True))
            print(f"| {element} | {algorithm} | {forces} | {free:.2f} | {found:.2f} |", flush=True)


if __name__ == "__main__":
    main()
