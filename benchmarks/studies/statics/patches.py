"""Patch tests of whole static runs: two blocks of nu = 0 on top of each other, flat, turned, cells 1:10 both ways."""

from __future__ import annotations

import numpy as np
from statics.common import INF, MORTARS, Figure, Rows, label

from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

YOUNG, DEPTH = 1e6, 0.01


def patch(algorithm: str, swap: bool, top: int, bottom: int, element: str = "q1", turn: float = 0.0) -> Scene:
    """`top` segments over `bottom` ones, three layers of cells each; turned by `turn` degrees as a whole."""
    angle = np.radians(turn)
    body = {"element": element, "material": "m", "rotate": turn}
    mesh = {"use": "rectangle", "x": [0.0, 1.0]}
    push = {"ux": float(DEPTH * np.sin(angle)), "uy": float(-DEPTH * np.cos(angle))}
    return Scene.from_data(
        {
            "name": "patch",
            "integrator": {"use": "newton", "steps": 1},
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1.0}},
            "bodies": {
                "upper": body | {"mesh": mesh | {"y": [0.5, 1.0], "cells": [top, 3]}},
                "lower": body | {"mesh": mesh | {"y": [0.0, 0.5], "cells": [bottom, 3]}},
            },
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm, "swap": swap}],
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top"} | push],
            "record": {"recorders": []},
        }
    )


def patch_figures(results: Results, turn: float, most: float) -> list[Figure]:
    """Largest errors of displacements and stresses over the largest exact ones."""
    angle = np.radians(turn)
    axis = np.array([-np.sin(angle), np.cos(angle)])
    exact = -DEPTH * (results.nodes @ axis)[:, None] * axis
    pressed = -YOUNG * DEPTH * np.outer(axis, axis)
    stress = np.concatenate([values.reshape(-1, 4) for values in results.stress.values()])
    wanted = np.array([pressed[0, 0], pressed[1, 1], 0.0, pressed[0, 1]])
    return [
        Figure("displacement", float(np.abs(results.displacement - exact).max()) / DEPTH, most=most),
        Figure("stress", float(np.abs(stress - wanted).max()) / (YOUNG * DEPTH), most=most),
        Figure("iterations", float(results.summary["iterations"])),
    ]


def case_patch() -> Rows:
    """4 over 5, 4 over 7 and 3 over 10 segments, either slave, linear and quadratic; at 30 degrees too."""
    for algorithm in (*MORTARS, "node-on-segment"):
        for swap in (False, True):
            for cells in ((4, 5), (4, 7), (3, 10)):
                for element, turn in (("q1", 0.0), ("q2-lagrange", 0.0), ("q1", 30.0)):
                    if algorithm == "node-on-segment" and (element, turn) != ("q1", 0.0):
                        continue
                    results = simulate(patch(algorithm, swap, *cells, element, turn))
                    most = INF if algorithm not in MORTARS else 1e-10 if turn else 1e-11
                    slave = "lower slave" if swap else "upper slave"
                    variant = label(algorithm, slave, f"{cells[0]} over {cells[1]}, {element}, {turn:g} degrees")
                    yield variant, patch_figures(results, turn, most)


def case_patch_ratio() -> Rows:
    """1 over 10 and 10 over 1 segments."""
    for algorithm in MORTARS:
        for swap in (False, True):
            for cells in ((1, 10), (10, 1)):
                slave = "lower slave" if swap else "upper slave"
                results = simulate(patch(algorithm, swap, *cells))
                yield label(algorithm, slave, f"{cells[0]} over {cells[1]}"), patch_figures(results, 0.0, 1e-11)
