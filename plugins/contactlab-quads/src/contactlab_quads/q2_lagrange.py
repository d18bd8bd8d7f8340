"""The biquadratic quadrilateral with 3x3 Gauss points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from contactlab.api import Element, Floats, Quadrature
from contactlab_quads.quadratic import EDGES, GAUSS_3X3, MID_SIDES


@dataclass(frozen=True)
class Q2Lagrange(Element):
    """Nine nodes, nine points. Mass by Lobatto quadrature at the nodes: 1/36, 4/36 and 16/36."""

    nodes: ClassVar[Floats] = np.concatenate([MID_SIDES, np.zeros((1, 2))])
    edges: ClassVar[tuple[tuple[int, ...], ...]] = EDGES
    degree: ClassVar[int] = 2
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "quadrature"
    without: ClassVar[Mapping[str, str]] = {"quadratic shape functions": "q1"}

    def functions(self, points: Floats) -> Floats:
        """Products of the parabolas that are 1 at -1, 0 or 1 and 0 at the other two."""
        along_xi, along_eta = (
            np.stack([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)], axis=-1) for s in points.T
        )
        i, j = np.rint(self.nodes + 1.0).astype(int).T
        return np.asarray(along_xi[:, i] * along_eta[:, j])

    def quadrature(self) -> Quadrature:
        """Rule of 3x3 Gauss points."""
        return GAUSS_3X3
