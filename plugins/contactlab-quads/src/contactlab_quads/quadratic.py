"""Nodes, sides and the 3x3 rule of both quadratic quadrilaterals."""

from __future__ import annotations

from typing import Final

import numpy as np

from contactlab.api import Quadrature

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
