"""The quadratic serendipity quadrilateral with 3x3 Gauss points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from contactlab.api import Element, Floats, Quadrature, Shape
from contactlab_quads.quadratic import EDGES, GAUSS_3X3, MID_SIDES, edge_trace


@dataclass(frozen=True)
class Q2(Element):
    """Eight nodes, nine points. Mass by Hinton, Rock & Zienkiewicz: 3/76 at corners, 16/76 at mid-sides.

    Row sums would make the corner masses negative. The masses of corner and mid nodes differ by more than
    five times, so contact forces ripple from node to node even where the pressure is smooth.
    """

    nodes: ClassVar[Floats] = MID_SIDES
    edges: ClassVar[tuple[tuple[int, ...], ...]] = EDGES
    degree: ClassVar[int] = 2
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "hrz"
    without: ClassVar[Mapping[str, str]] = {"quadratic shape functions": "q1"}

    def shape(self, points: Floats) -> Shape:
        """Corners (1 + a)(1 + b)(a + b - 1)/4 with a = xi_a xi, b = eta_a eta; mid-sides (1 - xi^2)(1 + b)/2."""
        xi, eta = points[:, 0], points[:, 1]
        value, derivative = np.empty((len(points), 8)), np.empty((len(points), 8, 2))
        for k, (x, y) in enumerate(self.nodes):
            a, b = x * xi, y * eta
            if x != 0.0 and y != 0.0:
                value[:, k] = 0.25 * (1.0 + a) * (1.0 + b) * (a + b - 1.0)
                derivative[:, k, 0] = 0.25 * x * (1.0 + b) * (2.0 * a + b)
                derivative[:, k, 1] = 0.25 * y * (1.0 + a) * (a + 2.0 * b)
            elif x == 0.0:
                value[:, k] = 0.5 * (1.0 - xi**2) * (1.0 + b)
                derivative[:, k, 0] = -xi * (1.0 + b)
                derivative[:, k, 1] = 0.5 * y * (1.0 - xi**2)
            else:
                value[:, k] = 0.5 * (1.0 - eta**2) * (1.0 + a)
                derivative[:, k, 0] = 0.5 * x * (1.0 - eta**2)
                derivative[:, k, 1] = -eta * (1.0 + a)
        return Shape(value, derivative)

    def quadrature(self) -> Quadrature:
        """Rule of 3x3 Gauss points."""
        return GAUSS_3X3

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Values and derivatives (n, 3) of the three parabolas of an edge at s."""
        return edge_trace(s)
