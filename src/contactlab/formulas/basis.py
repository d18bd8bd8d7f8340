"""Breaks of a multiplier basis on a segment, and the degree of its polynomials: found from their values.

Integrals are then exact with as few Gauss points as the basis needs, and an author says neither.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from contactlab.api.formulas import formulas_of
from contactlab.api.segments import Covered
from contactlab.formulas.parameters import parameters_of, values_of

POINTS, DEGREE, BREAKS = 17, 8, 8
"""Samples of a polynomial fit, its highest degree, and most breaks: a basis with more is not polynomial, and
is integrated by the rule that is exact for this degree."""
ROUND_OFF = 1e-12  # of the coefficients, over the largest value
_ANGLES = np.pi * np.arange(POINTS) / (POINTS - 1)
_PLACES = 0.5 - 0.5 * np.cos(_ANGLES)
_COEFFICIENTS = np.linalg.inv(np.polynomial.chebyshev.chebvander(-np.cos(_ANGLES), POINTS - 1))


class Shape(NamedTuple):
    """Breaks between 0 and 1 in increasing order, and the highest degree of the polynomials between them."""

    breaks: tuple[float, ...]
    degree: int


def shape_of(part: Any) -> Shape:
    """Return the shape of the basis of a `SegmentContact` on a segment with full overlap."""
    kind = part.__class__
    basis = formulas_of(kind)["basis"]
    given = {"covered": Covered(0.0, 1.0), "p": parameters_of(kind)(*values_of(part).ravel())}
    return pieces_of(lambda xi: basis.plain(*({"xi": xi, **given}[name] for name in basis.arguments)))


def pieces_of(basis: Callable[[float], tuple[float, float]]) -> Shape:
    """Return the shape of functions of xi, 0 to 1, which are evaluated at single numbers."""
    low, breaks, degree = 0.0, [], 0
    while (whole := _degree(basis, low, 1.0)) is None:
        inside, outside = low, 1.0
        while inside < (middle := 0.5 * (inside + outside)) < outside:
            inside, outside = (inside, middle) if _degree(basis, low, middle) is None else (middle, outside)
        degree = max(degree, _degree(basis, low, 0.5 * (low + inside)) or 0)  # near a bend round-off dominates
        breaks.append(low := outside)
        if len(breaks) > BREAKS:
            return Shape((), DEGREE)
    return Shape(tuple(breaks), max(degree, whole))


def _degree(basis: Callable[[float], tuple[float, float]], low: float, high: float) -> int | None:
    """Return the degree of the polynomials that the functions are from `low` to `high`; None if they are none."""
    values = np.array([basis(float(low + (high - low) * place)) for place in _PLACES])
    found = np.abs(_COEFFICIENTS @ values).max(axis=1) > ROUND_OFF * np.abs(values).max()
    degree = int(np.flatnonzero(found).max(initial=0))
    return degree if degree <= DEGREE else None
