"""What both quadratic quadrilaterals share: nodes, sides, traces and the 3x3 rule."""

from __future__ import annotations

from typing import Final

import numpy as np

from contactlab.api import Floats, Quadrature

MID_SIDES: Final = np.array(
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]
)
"""Corners, then mid-sides, counter-clockwise."""

EDGES: Final = ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))


def _gauss_3x3() -> Quadrature:
    points, weights = np.polynomial.legendre.leggauss(3)
    xi, eta = np.meshgrid(points, points)
    return Quadrature(np.stack([xi.ravel(), eta.ravel()], axis=1), np.outer(weights, weights).ravel())


GAUSS_3X3: Final = _gauss_3x3()


def parabolas(s: Floats) -> tuple[Floats, Floats]:
    """Parabolas that are 1 at -1, 0 or 1 and 0 at the other two: values (len(s), 3) and derivatives."""
    value = np.stack([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)], axis=-1)
    return value, np.stack([s - 0.5, -2.0 * s, s + 0.5], axis=-1)


def edge_trace(s: Floats) -> tuple[Floats, Floats]:
    """Trace on a side: values and derivatives (len(s), 3) of start, end and middle node."""
    value, derivative = parabolas(s)
    order = [0, 2, 1]
    return value[:, order], derivative[:, order]
