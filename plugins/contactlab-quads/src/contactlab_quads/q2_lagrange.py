"""The biquadratic quadrilateral with 3x3 Gauss points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from contactlab.api import Element, Floats, Quadrature, Shape
from contactlab_quads.quadratic import EDGES, GAUSS_3X3, MID_SIDES, edge_trace, parabolas


@dataclass(frozen=True)
class Q2Lagrange(Element):
    """Nine nodes, nine points. Mass by Lobatto quadrature at the nodes: 1/36, 4/36 and 16/36."""

    nodes: ClassVar[Floats] = np.concatenate([MID_SIDES, np.zeros((1, 2))])
    edges: ClassVar[tuple[tuple[int, ...], ...]] = EDGES
    degree: ClassVar[int] = 2
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "quadrature"
    without: ClassVar[Mapping[str, str]] = {"quadratic shape functions": "q1"}

    def shape(self, points: Floats) -> Shape:
        """Products of the parabolas through -1, 0 and 1."""
        along_xi, d_xi = parabolas(points[:, 0])
        along_eta, d_eta = parabolas(points[:, 1])
        i, j = np.rint(self.nodes + 1.0).astype(int).T
        derivative = np.stack([d_xi[:, i] * along_eta[:, j], along_xi[:, i] * d_eta[:, j]], axis=-1)
        return Shape(along_xi[:, i] * along_eta[:, j], derivative)

    def quadrature(self) -> Quadrature:
        """Rule of 3x3 Gauss points."""
        return GAUSS_3X3

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Values and derivatives (n, 3) of the three parabolas of an edge at s."""
        return edge_trace(s)
