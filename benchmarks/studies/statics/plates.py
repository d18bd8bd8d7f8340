"""Rough contact: a plate on a plane (SSNV128 of Code_Aster), at high friction too; a pulled block; the Tresca block."""

from __future__ import annotations

import numpy as np
from statics.common import Figure, ordered, percent, scene

from contactlab.api import Floats
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

PUBLISHED = {0.0: 2.86e-5, 1.25e-3: 2.72e-5, 5e-3: 2.28e-5, 7.5e-3: 1.98e-5, 11.25e-3: 1.50e-5}
"""Tangential displacements [m] at places along the plane, mu = 1, tolerance 5 %."""


def plate(algorithm: str, mu: float = 1.0, cells: int = 32, steps: int = 1) -> Scene:
    """Metres and pascals: 40 x 40 mm, pressed from above and harder from the left, symmetry on the right."""
    contact = {
        "slave": "plate.bottom",
        "master": "plane",
        "algorithm": algorithm,
        "friction": {"use": "coulomb", "mu": mu},
    }
    mesh = {"use": "rectangle", "x": [0.0, 0.04], "y": [0.0, 0.04], "cells": [cells, cells]}
    return scene(
        "plate",
        steps,
        {"m": {"young": 1.3e11, "poisson": 0.2}},
        contact,
        bodies={"plate": {"element": "q1", "material": "m", "mesh": mesh}},
        rigid={"plane": {"line": [[0.06, 0.0], [-0.02, 0.0]]}},
        supports=[{"on": "plate.right", "ux": 0.0}],
        loads=[
            {"on": "plate.top", "pressure": 5e7, "follower": False},
            {"on": "plate.left", "pressure": 15e7, "follower": False},
        ],
    )


def bottom_displacements(results: Results) -> tuple[Floats, Floats]:
    """x and u_x [m] along the plane."""
    x0, u = results.nodes[:, 0], results.displacement
    own = np.unique(results.cells["plate"])
    bottom = own[np.isclose(results.nodes[own, 1], 0.0)]
    x, moved = ordered(x0[bottom], u[bottom, 0])
    return x, moved


def plate_figures(results: Results, judged: bool = True) -> list[Figure]:
    """Against the published displacements, and the three zones."""
    x0, moved = bottom_displacements(results)
    found = [Figure("iterations", float(results.summary["iterations"]))]
    if judged:
        found += [
            percent(f"u_x at {1e3 * x:g} mm", float(np.interp(x, x0, moved)) / exact - 1.0, 5.0)
            for x, exact in PUBLISHED.items()
        ]
    curve = results.contact["contacts.0"].last
    x, state = ordered(curve.x, curve.state)
    return [
        *found,
        Figure("open until mm", 1e3 * float(x[state == 0].max(initial=0.0))),
        Figure("sticks from mm", 1e3 * float(x[state == 1].min(initial=np.inf))),
        Figure("cone violation", float(results.summary["contacts"]["contacts.0"]["cone_violation"]), most=1e-8),
    ]


def pulled_block(algorithm: str, mu: float, shear: float, poisson: float = 0.3, cells: int = 20) -> Scene:
    """10 x 10 under a pressure of 100, sheared evenly all around so that the plane holds 10 * `shear`; nothing else
    holds it."""
    contact = {
        "slave": "block.bottom",
        "master": "plane",
        "algorithm": algorithm,
        "friction": {"use": "coulomb", "mu": mu},
    }
    mesh = {"use": "rectangle", "x": [0.0, 10.0], "y": [0.0, 10.0], "cells": [cells, cells]}
    return scene(
        "pulled-block",
        1,
        {"m": {"young": 1e5, "poisson": poisson}},
        contact,
        bodies={"block": {"element": "q1", "material": "m", "mesh": mesh}},
        rigid={"plane": {"line": [[20.0, 0.0], [-10.0, 0.0]]}},
        loads=[
            {"on": "block.top", "pressure": 100.0, "shear": -shear, "follower": False},
            {"on": "block.left", "shear": shear, "follower": False},
            {"on": "block.right", "shear": shear, "follower": False},
        ],
    )
