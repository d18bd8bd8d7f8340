"""Rigid profiles pressed on a half plane: the scene, and pressures by the sum of flat punches.

A smooth, even, convex profile of height h(x) that is pressed to a half-width b carries P(b) = E* F(b) with
F(b) = int_0^b x h'(x) (b^2 - x^2)^(-1/2) dx, and p(x) = E*/pi int_|x|^b F'(c) (c^2 - x^2)^(-1/2) dc: while contact
grows from c to c + dc, a flat punch of half-width c adds dP/(pi (c^2 - x^2)^(1/2)). With c^2 = x^2 + u^2 the integrand
is smooth.
Source: Jaeger, Z. angew. Math. Phys. 1995; Barber, Contact Mechanics, 2018, 6.6.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from contactlab.api import Floats, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import block_mesh, half_width, peak_error
from contactlab_cases.statics import cell_size, force_of, l2_error, plane_strain, static_job

YOUNG, SIZE = 70000.0, 1.0  # MPa; mm, a quarter of the block's width and depth
MODULUS = plane_strain(YOUNG)

Function = Callable[[Floats], Floats]


def pressed(
    setup: Setup, line: list[list[float]], force: float, half: float, h: float, contact: dict[str, Any] | None = None,
    mesh: dict[str, Any] | None = None,
) -> Job:  # fmt: skip
    """A rigid line, its lowest point at y = 0, on a block whose foot comes up by what about `force` [N/mm] needs.

    half  of the contact [mm], about; h  cells there [mm], or a mesh of its own
    """
    up = 2.0 * force / (np.pi * MODULUS) * (0.5 + np.log(8.0 * SIZE / half))
    return static_job(
        "pressed", setup, {"plane": {"young": YOUNG, "poisson": 0.3}},
        {"block": {"material": "plane", "mesh": mesh or block_mesh(SIZE, h / SIZE, 1.6 * half / SIZE)}},
        {"slave": "block.top", "master": "punch"} | (contact or {}),
        rigid={"punch": {"line": line}},
        supports=[{"on": "block.bottom", "ux": 0.0, "uy": float(up)}],
    )  # fmt: skip


def half_width_of(force: float, total: Function, most: float) -> float:
    """b [mm] at which F(b) = force/E*; `total` is F."""
    return float(brentq(lambda b: float(total(np.asarray(b))) - force / MODULUS, 1e-9 * most, most))


def pressure(x: Floats, b: float, rate: Function, begin: float = 0.0) -> Floats:
    """p(x) [MPa] of contact |x| < b; `rate` is F'(c)/c, zero up to c = `begin`."""
    points, weights = np.polynomial.legendre.leggauss(40)
    x = np.abs(np.asarray(x))[:, None]
    first, last = (np.sqrt(np.maximum(0.0, c**2 - x**2)) for c in (begin, b))
    u = first + (last - first) * 0.5 * (points + 1.0)
    return np.asarray(MODULUS / np.pi * 0.5 * (last - first)[:, 0] * (rate(np.sqrt(x**2 + u**2)) @ weights))


def errors(peak: float, l2: float, why: str) -> list[Measure]:
    """Return measures of errors of the pressure, and of the half-width in cells."""
    return [
        error("L2 of the pressure", l2, why),
        error("largest pressure", peak, why),
        error("half-width in cells", 1.0, "nodes show the end of contact to half a segment", "h"),
        reported("cells in the half-width"),
    ]


def values(record: Record, total: Function, rate: Function, begin: float, most: float) -> dict[str, float]:
    """Compare with the closed form of the measured force."""
    curve = record.curve()
    b = half_width_of(force_of(record), total, most)
    at, size = np.linspace(-b, b, 2001), cell_size(curve, 1.3 * b)

    def exact(x: Floats) -> Floats:
        return pressure(x, b, rate, begin)

    return {
        "L2 of the pressure": l2_error(curve.x, curve.pressure, exact, 1.5 * b),
        "largest pressure": peak_error(record, at, exact),
        "half-width in cells": (half_width(curve) - b) / size,
        "cells in the half-width": b / size,
    }
