"""Hertz: a cylinder on a block; like and unlike moduli, like and unlike meshes, and a nearly incompressible block.

Discs are pushed down by a prescribed displacement; closed forms are evaluated at the forces measured with it, so that
the compliance of the finite bodies plays no part. Half-plane theory takes the circle for a parabola and the block
for infinite: what that makes is seen on the finest meshes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from statics.common import (
    INF,
    MORTARS,
    Figure,
    Rows,
    graded_count,
    l2_error,
    label,
    ordered,
    percent,
    scene,
    within,
)

from contactlab.api import ContactCurve, Floats
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

HALF = 0.4  # width of a disc's cut, in radii, on either side
STEEL, ALUMINIUM = 210000.0, 70000.0


def hertz(
    algorithm: str, swap: bool, radius: float = 10.0, moduli: tuple[float, float] = (70000.0, 70000.0), **keys: Any
) -> Scene:
    """Arc of `radius` on a block 4 x 4 radii wide; cells in contact: radius * `h` there, `ratio` h on the disc."""
    h, ratio, growth = keys.pop("h", 0.00114), keys.pop("ratio", 1.0), keys.pop("growth", 1.045)
    depth, poisson, steps = keys.pop("depth", 8e-4), keys.pop("poisson", 0.3), keys.pop("steps", 1)
    zone, element = keys.pop("zone", 0.03), keys.pop("element", "q1")
    elements = element if isinstance(element, tuple) else (element, element)
    bodies = {
        "disc": {"element": elements[0], "material": "upper", "mesh": disc_mesh(radius, h * ratio, growth)},
        "block": {"element": elements[1], "material": "lower", "mesh": block_mesh(radius, h, zone)},
    }
    contact = {"slave": "disc.arc", "master": "block.top", "algorithm": algorithm, "swap": swap}
    contact |= keys.pop("contact", {})
    supports = keys.pop("supports", [{"on": "disc.top", "ux": 0.0, "uy": -depth * radius}])
    materials = {
        "upper": {"young": moduli[0], "poisson": poisson},
        "lower": {"young": moduli[1], "poisson": poisson},
    }
    held = [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}]
    return scene("hertz", steps, materials, contact, bodies=bodies, supports=[*held, *supports], **keys)


def disc_mesh(radius: float, h: float, growth: float) -> dict[str, Any]:
    """Cells grow from `h` radii at the middle of the arc to its ends; none where growth is 1."""
    columns = round(HALF / h) if growth == 1.0 else graded_count(HALF, h, growth)
    rows = graded_count(0.5, h, 1.12)
    return {
        "use": "arc-block", "radius": radius, "half_width": HALF * radius, "top": 0.5 * radius,
        "cells": [2 * columns, rows], "grading": [growth ** (columns - 1), 1.12 ** (rows - 1)],
    }  # fmt: skip


def block_mesh(radius: float, h: float, zone: float) -> dict[str, Any]:
    """Equal cells of `h` radii over |x| < zone radii, larger ones beyond and below."""
    fine, outside, rows = max(2, round(2.0 * zone / h)), 16, graded_count(4.0, h, 1.15)
    growth = 4.0 / h / outside
    return {
        "use": "rectangle",
        "x": [-2.0 * radius, -zone * radius, zone * radius, 2.0 * radius],
        "y": [-4.0 * radius, 0.0],
        "cells": [[outside, fine, outside], rows],
        "grading": [[1.0 / growth, 1.0, growth], 1.15 ** -(rows - 1)],
    }


def force_of(results: Results) -> float:
    """What the block is pressed with [N/mm]."""
    return float(results.summary["reactions"]["block.bottom"][1])


def pressed(make: Callable[[float], Scene], force: float, depth: float) -> Results:
    """The run at the depth that gives the force within 0.1 %, found from `depth`; make(depth) is the scene."""
    results = simulate(make(depth))
    for _ in range(6):
        found = force_of(results)
        if abs(found / force - 1.0) < 1e-3:
            break
        depth *= (force / found) ** 0.9
        results = simulate(make(depth))
    return results


def hertz_profile(force: float, radius: float, modulus: float) -> tuple[float, float, Callable[[Floats], Floats]]:
    """Half-width a, largest pressure p0, and p(x)."""
    a = float(np.sqrt(4.0 * force * radius / (np.pi * modulus)))
    p0 = 2.0 * force / (np.pi * a)
    return a, p0, lambda x: np.asarray(p0 * np.sqrt(np.maximum(0.0, 1.0 - x**2 / a**2)))


def hertz_figures(results: Results, radius: float, modulus: float, aims: tuple[float, float, float]) -> list[Figure]:
    """Against p = p0 (1 - x^2/a^2)^(1/2) of the measured force; aims: p0, half-width in cells, L2."""
    curve = results.contact["contacts.0"].last
    a, p0, exact = hertz_profile(force_of(results), radius, modulus)
    size = cell_size(curve, a)
    return [
        Figure("a/h", a / size),
        percent("largest pressure", float(curve.pressure.max()) / p0 - 1.0, 100.0 * aims[0]),
        within("half-width / h", (half_width(curve) - a) / size, aims[1]),
        percent("L2 of p", l2_error(curve.x, curve.pressure, exact, 2.0 * a), 100.0 * aims[2]),
        percent("L2 of exact nodal values", l2_error(curve.x, exact(curve.x), exact, 2.0 * a)),
    ]


def cell_size(curve: ContactCurve, a: float) -> float:
    """Mean length of the slave's segments in contact."""
    x = np.sort(curve.x[np.abs(curve.x) < 1.2 * a])
    return float(np.diff(x).mean())


def half_width(curve: ContactCurve) -> float:
    """Half of the way between the middles of the segments on which contact ends."""
    x, force = ordered(curve.x, curve.nodal_pressure)
    closed = np.flatnonzero(force > 0.0)
    first, last = closed[0], closed[-1]
    ends = x[max(first - 1, 0)] + x[first], x[last] + x[min(last + 1, len(x) - 1)]
    return 0.25 * float(ends[1] - ends[0])


def side(swap: bool) -> str:
    """Which body is the slave."""
    return "block slave" if swap else "disc slave"


def cgs1(algorithm: str, swap: bool, cells: int) -> Results:
    """NAFEMS CGS-1: steel, R = 50, on aluminium, 35000 N/mm; `cells` in a half-width of 6.21 on both bodies."""
    h = 6.2146 / cells / 50.0

    def make(depth: float) -> Scene:
        return hertz(algorithm, swap, 50.0, (STEEL, ALUMINIUM), h=h, growth=1.0, zone=0.25, depth=depth)

    return pressed(make, 35000.0, 0.03)


def case_cgs1() -> Rows:
    """a/h = 8, 16 and 32, against theory and against the own solution at 64."""
    modulus = 1.0 / (0.91 / STEEL + 0.91 / ALUMINIUM)
    fine = cgs1("mortar-p1", True, 64).contact["contacts.0"].last
    x, p = ordered(fine.x, fine.pressure)
    for algorithm in MORTARS:
        for swap in (False, True):
            for cells in (8, 16, 32):
                results = cgs1(algorithm, swap, cells)
                curve = results.contact["contacts.0"].last
                aims = (0.03, 0.5, 0.03) if cells == 8 else (0.03, INF, INF)
                own = l2_error(curve.x, curve.pressure, lambda at: np.interp(at, x, p), 12.0)
                nodal = l2_error(curve.x, np.interp(curve.x, x, p), lambda at: np.interp(at, x, p), 12.0)
                yield (
                    label(algorithm, side(swap), f"a/h = {cells}"),
                    [
                        *hertz_figures(results, 50.0, modulus, aims),
                        percent("L2 against own a/h = 64", own),
                        percent("L2 of its values at these nodes", nodal),
                    ],
                )
