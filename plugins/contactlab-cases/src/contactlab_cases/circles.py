"""A disc on a block and Hertz's solution for it: the scene, the closed form, and the numbers taken from a pressure.

The closed form is taken at the force that was measured, so that the compliance of the finite bodies plays no part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Floats, Job, Measure, Record, Setup, Solution
from contactlab.api.case import error, reported
from contactlab_cases.measures import PeakError
from contactlab_cases.statics import cell_size, force_of, graded_count, iterations, l2_error, ordered, static_job

HALF = 0.4
"""Width of a disc's cut, in radii, on either side."""

SOURCE = "Johnson 1985, Contact Mechanics, 4.2"


def disc_on_block(
    setup: Setup, radius: float, moduli: tuple[float, float], depth: float, h: float, ratio: float = 1.0,
    growth: float = 1.045, zone: float = 0.03, poisson: float = 0.3, name: str = "pressed", **keys: Any,
) -> Job:  # fmt: skip
    """Arc of `radius` on a block 4 x 4 radii wide, pushed down by `depth` radii.

    Cells in contact are radius * `h` long on the block and `ratio` times that on the disc; the block has cells of equal
    length over `zone` radii.
    """
    push = keys.pop("push", {"on": "disc.top", "ux": 0.0, "uy": -depth * radius})
    contact = {"slave": "disc.arc", "master": "block.top"} | keys.pop("contact", {})
    disc = {"material": "upper", "mesh": disc_mesh(radius, h * ratio, growth)} | keys.pop("disc", {})
    return static_job(
        name, setup,
        {"upper": {"young": moduli[0], "poisson": poisson}, "lower": {"young": moduli[1], "poisson": poisson}},
        {"disc": disc, "block": {"material": "lower", "mesh": block_mesh(radius, h, zone)}},
        contact, supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}, push], **keys,
    )  # fmt: skip


def disc_mesh(radius: float, h: float, growth: float) -> dict[str, Any]:
    """Cells grow from `h` radii at the middle of the arc to its ends; none if growth is 1."""
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


def hertz(force: float, radius: float, modulus: float) -> tuple[float, float, Callable[[Floats], Floats]]:
    """Half-width a [mm], largest pressure p0 [MPa], and p(x) of a force per length."""
    a = float(np.sqrt(4.0 * force * radius / (np.pi * modulus)))
    p0 = 2.0 * force / (np.pi * a)
    return a, p0, lambda x: np.asarray(p0 * np.sqrt(np.maximum(0.0, 1.0 - x**2 / a**2)))


def half_width(curve: ContactCurve) -> float:
    """Half of the way between the middles of the segments on which contact ends."""
    x, force = ordered(curve.x, curve.nodal_pressure)
    closed = np.flatnonzero(force > 0.0)
    first, last = closed[0], closed[-1]
    ends = x[max(first - 1, 0)] + x[first], x[last] + x[min(last + 1, len(x) - 1)]
    return 0.25 * float(ends[1] - ends[0])


def peak_error(record: Record, at: Floats, exact: Callable[[Floats], Floats]) -> float:
    """The measure `peak-error` of comparisons, against a closed form at points `at` that have its largest value."""
    return PeakError().evaluate(record, "contacts.0", Solution(at, exact(at), 0.0, "exact"))


def hertz_measures(peak: float, width: float, l2: float, why: str) -> list[Measure]:
    """Errors of p0 and of p, and of the half-width in segments; if one is infinite, it is only reported.

    A run that warns of a saw-tooth, or of forces at other nodes, has named what its errors of the pressure come from.
    """
    told = ("pressure-saw", "patch-test")
    return [
        _or_told(error("largest pressure", peak, why, codes=told)),
        _or_told(error("half-width in segments", width, "nodes show the end of contact to half a segment", "h")),
        _or_told(error("L2 of the pressure", l2, why, codes=told)),
        reported("L2 of exact nodal values"),
        reported("segments in the half-width"),
        reported("iterations"),
    ]


def _or_told(measure: Measure) -> Measure:
    return measure if math.isfinite(measure.most) else reported(measure.name, measure.unit)


def hertz_values(record: Record, radius: float, modulus: float, support: str = "block.bottom") -> dict[str, float]:
    """Compare with p = p0 (1 - x^2/a^2)^(1/2) of the measured force."""
    curve = record.curve()
    a, _, exact = hertz(force_of(record, support), radius, modulus)
    size = cell_size(curve, 1.2 * a)
    return {
        "largest pressure": peak_error(record, np.linspace(-a, a, 2001), exact),
        "half-width in segments": (half_width(curve) - a) / size,
        "L2 of the pressure": l2_error(curve.x, curve.pressure, exact, 2.0 * a),
        "L2 of exact nodal values": l2_error(curve.x, exact(curve.x), exact, 2.0 * a),
        "segments in the half-width": a / size,
        "iterations": iterations(record),
    }


def hertz_pressure(record: Record, radius: float, modulus: float, support: str = "block.bottom") -> Solution:
    """The closed form that `hertz_values` measures against."""
    a, _, exact = hertz(force_of(record, support), radius, modulus)
    x = a * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2001))  # denser to the edges, where its slope has no end
    return Solution(x, exact(x), 0.0, "exact", window=(-2.0 * a, 2.0 * a))


def only(done: Mapping[str, Record]) -> Record:
    """Return the record of a case that has one run."""
    (record,) = done.values()
    return record
