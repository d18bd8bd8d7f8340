"""Rough contact: a plate on a plane (SSNV128 of Code_Aster), at high friction too; a pulled block; the Tresca block."""

from __future__ import annotations

import numpy as np
from statics.common import INF, MORTARS, Figure, Rows, label, ordered, percent, scene, stopped

import contactlab
from contactlab.api import Floats
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
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


def case_plate() -> Rows:
    """mu = 1, two meshes."""
    for algorithm in MORTARS:
        for cells in (32, 64):
            yield label(algorithm, f"{cells} cells"), plate_figures(simulate(plate(algorithm, cells=cells)))


def case_high_friction() -> Rows:
    """mu = 2, 5 and 20; at 50 and beyond the iteration goes round in circles, and the run says so."""
    for algorithm in MORTARS:
        for mu in (2.0, 5.0, 20.0, 1000.0):
            results = simulate(plate(algorithm, mu))
            yield label(algorithm, f"mu = {mu:g}"), stopped(results, False) or plate_figures(results, False)


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


def pulled_figures(results: Results, unlimited: Results) -> list[Figure]:
    """Against the same block on a plane whose friction has no bound."""
    size, curve, free = 0.5, results.contact["contacts.0"].last, unlimited.contact["contacts.0"].last
    bottom = np.isclose(results.nodes[:, 1], 0.0) & np.isin(np.arange(len(results.nodes)), results.cells["block"])
    slip = np.abs(results.displacement[bottom, 0])[np.argsort(results.nodes[bottom, 0])]
    state = ordered(curve.x, curve.state)[1]
    pulls, others = (np.array(r.summary["reactions"]["plane"]) for r in (results, unlimited))
    normal, other = (c.nodal_pressure[np.argsort(c.x)] for c in (curve, free))
    return [
        Figure("iterations", float(results.summary["iterations"])),
        Figure("sticking nodes of 21", float(np.count_nonzero(state == 1))),
        Figure("slip of sticking nodes / h", float(slip[state == 1].max(initial=0.0)) / size, most=1e-9),
        percent("reactions against unlimited", float(np.abs(pulls / others - 1.0).max()), 0.1),
        percent("nodal pressures against unlimited", float(np.abs(normal - other).max() / other.mean())),
    ]


def case_pulled_block() -> Rows:
    """Q = 0.9 mu P with mu = 1, 2 and 5; nu = 0 is in uniform shear, nu = 0.3 slides at its corners."""
    for algorithm in MORTARS:
        for poisson in (0.0, 0.3):
            for mu in (1.0, 2.0, 5.0):
                results, unlimited = (
                    simulate(pulled_block(algorithm, value, 90.0 * mu, poisson)) for value in (mu, 1e9)
                )
                variant = label(algorithm, f"nu = {poisson:g}", f"mu = {mu:g}")
                yield variant, stopped(results) or stopped(unlimited) or pulled_figures(results, unlimited)


def case_tresca() -> Rows:
    """Where contact ends, in an independent code: 0.717 with friction everywhere, 0.715 to 0.727 where closed."""
    ends = {"everywhere": (0.717, 0.717, 2.25e-3), "closed": (0.715, 0.727, 4.9e-4)}
    for algorithm in MORTARS:
        for where, (lower, upper, lift) in ends.items():
            changes = {"contacts.0.algorithm": algorithm, "contacts.0.friction.where": where, "level": 8}
            results = simulate(contactlab.load_scene("tresca-block").with_(changes))
            curve, h = results.contact["contacts.0"].last, 1.3 / 208
            start = np.linspace(0.0, 1.3, len(curve.x))
            closed = float(start[np.asarray(curve.nodal_pressure) > 0.0].max())
            yield (
                label(algorithm, where),
                [
                    Figure("iterations", float(results.summary["iterations"])),
                    Figure("last closed node mm", closed, lower - h, upper + h),
                    percent("lift against the other code", float(np.max(curve.gap)) / lift - 1.0, 2.0),
                    Figure("steps taken back", float(sum("taken back" in e.text for e in results.events)), most=INF),
                ],
            )
