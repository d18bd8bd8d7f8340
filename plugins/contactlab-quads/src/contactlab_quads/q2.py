"""The quadratic serendipity quadrilateral with 3x3 Gauss points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from contactlab.api import Element, Floats, Quadrature
from contactlab_quads.quadratic import EDGES, GAUSS_3X3, MID_SIDES


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

    def functions(self, points: Floats) -> Floats:
        """Corners (1 + a)(1 + b)(a + b - 1)/4 with a = xi_a xi, b = eta_a eta; mid-sides (1 - xi^2)(1 + b)/2."""
        a, b = points[:, :1] * self.nodes[:, 0], points[:, 1:] * self.nodes[:, 1]
        corners = 0.25 * (1.0 + a) * (1.0 + b) * (a + b - 1.0)
        across_x, across_y = (0.5 * (1.0 - points[:, k : k + 1] ** 2) for k in range(2))
        on_x, on_y = self.nodes[:, 0] == 0.0, self.nodes[:, 1] == 0.0
        return np.where(on_x, across_x * (1.0 + b), np.where(on_y, across_y * (1.0 + a), corners))

    def quadrature(self) -> Quadrature:
        """Rule of 3x3 Gauss points."""
        return GAUSS_3X3
