"""Complete contact: a rigid flat punch, and an elastic square one whose corners press with a power of the distance."""

from __future__ import annotations

from typing import Any

import numpy as np
from statics.common import INF, MORTARS, Figure, Rows, graded_count, l2_error, label, ordered, percent, scene, within

from contactlab.api import Floats
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

EXPONENTS = {1.0: -0.2260, 10.0: -0.4443, 100.0: -0.4937, 0.1: -0.0378}
"""p ~ r^e at a frictionless corner of 90 degrees on a half-plane, nu = 0.3, by E of the punch over E of the block."""


def rigid_punch(algorithm: str, cells: int = 40) -> Scene:
    """A rigid punch of half width 1 on a block 20 x 20, which is the slave; frictionless."""
    mesh = {
        "use": "rectangle", "x": [-10.0, -1.5, 1.5, 10.0], "y": [-20.0, 0.0],
        "cells": [[16, 3 * cells // 2, 16], 40], "grading": [[0.05, 1.0, 20.0], 0.005],
    }  # fmt: skip
    line = [[-1.0, 1.0], [-1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
    return scene(
        "punch",
        1,
        {"m": {"young": 1000.0, "poisson": 0.3}},
        {"slave": "block.top", "master": "punch", "algorithm": algorithm},
        bodies={"block": {"element": "q1", "material": "m", "mesh": mesh}},
        rigid={"punch": {"line": line, "uy": {"ramp": "linear", "to": -1e-4}}},
        supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
    )


def rigid_figures(results: Results, algorithm: str) -> list[Figure]:
    """Against the rigid punch on a half-plane, of the measured force.

    A single nodal force makes the neighbouring multipliers negative by 24 (P0) and 46 % (P1) of its own.
    """
    curve = results.contact["contacts.0"].last
    x, p = ordered(curve.x, curve.pressure)
    force = float(results.summary["reactions"]["block.bottom"][1])

    def exact(at: Floats) -> Floats:
        return np.asarray(force / (np.pi * np.sqrt(np.maximum(1e-9, 1.0 - at**2))))

    middle, undershoot = float(np.interp(0.0, x, p)) / (0.5 * force), max(0.0, float(-p.min() / p.max()))
    return [
        Figure("iterations", float(results.summary["iterations"])),
        percent("L2 over 0.9 a", l2_error(x, p, exact, 0.9), 3.0),
        percent("p(0)", middle / (2.0 / np.pi) - 1.0),
        Figure("undershoot %", 100.0 * undershoot, most=24.0 if algorithm == "mortar-p0" else 46.0),
    ]


def case_rigid_punch() -> Rows:
    """Two meshes."""
    for algorithm in MORTARS:
        for cells in (40, 80):
            yield (
                label(algorithm, f"{cells} cells across"),
                rigid_figures(simulate(rigid_punch(algorithm, cells)), algorithm),
            )


def elastic_punch(algorithm: str, swap: bool, ratio: float, smallest: float = 0.0005, growth: float = 1.1) -> Scene:
    """Half width 1, height 4, on a block 20 x 20; cells grow from `smallest` at the corners."""
    inside, beside = (graded_count(length, smallest, growth) for length in (1.0, 9.0))
    down, up = (graded_count(length, smallest, growth) for length in (20.0, 4.0))
    big = [growth ** (n - 1) for n in (inside, beside, down, up)]
    punch: dict[str, Any] = {
        "use": "rectangle", "x": [-1.0, 0.0, 1.0], "y": [0.0, 4.0],
        "cells": [[inside, inside], up], "grading": [[big[0], 1.0 / big[0]], big[3]],
    }  # fmt: skip
    # a half more cells than above, so that nodes do not match
    more = inside + inside // 2
    block: dict[str, Any] = {
        "use": "rectangle", "x": [-10.0, -1.0, 0.0, 1.0, 10.0], "y": [-20.0, 0.0],
        "cells": [[beside, more, more, beside], down],
        "grading": [[1.0 / big[1], big[0], 1.0 / big[0], big[1]], 1.0 / big[2]],
    }  # fmt: skip
    return scene(
        "elastic-punch",
        1,
        {"punch": {"young": 1000.0 * ratio, "poisson": 0.3}, "block": {"young": 1000.0, "poisson": 0.3}},
        {"slave": "punch.bottom", "master": "block.top", "algorithm": algorithm, "swap": swap},
        bodies={
            "punch": {"element": "q1", "material": "punch", "mesh": punch},
            "block": {"element": "q1", "material": "block", "mesh": block},
        },
        supports=[
            {"on": "block.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "punch.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -1e-5}},
        ],
    )


def elastic_figures(results: Results, exponent: float) -> list[Figure]:
    """Slope of log p over log r from three cells to a fifth of the half-width, at the right corner."""
    curve = results.contact["contacts.0"].last
    x, p = ordered(curve.x, curve.pressure)
    inner = np.flatnonzero(x <= 1.0 + 1e-6)
    h, r = float(np.diff(x[inner])[-1]), 1.0 - x
    near = (r > 3.0 * h) & (r < 0.2)
    slope = float(np.polyfit(np.log(r[near]), np.log(p[near]), 1)[0])
    closed = np.asarray(curve.nodal_pressure)[np.argsort(curve.x)] > 0.0
    return [
        Figure("iterations", float(results.summary["iterations"])),
        Figure("nodes in the fit", float(np.count_nonzero(near))),
        Figure("slope", slope),
        within("slope less the exact one", slope - exponent, 0.03),
        Figure("undershoot %", 100.0 * max(0.0, float(-p.min() / p.max())), most=INF),
        Figure("last closed node mm", float(x[closed].max())),
    ]


def case_elastic_punch() -> Rows:
    """Ratios of moduli 1, 10, 100 and 0.1."""
    for algorithm in MORTARS:
        for swap in (False, True):
            for ratio, exponent in EXPONENTS.items():
                results = simulate(elastic_punch(algorithm, swap, ratio))
                slave = "block slave" if swap else "punch slave"
                yield label(algorithm, slave, f"E ratio {ratio:g}, e = {exponent}"), elastic_figures(results, exponent)
