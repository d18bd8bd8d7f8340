"""The bilinear quadrilateral with 2x2 Gauss points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from contactlab.api import BlockKernels, Element, Floats, Kinematics, Quadrature

_G = 1.0 / np.sqrt(3.0)


@dataclass(frozen=True)
class Q1(Element):
    """Four nodes, four points. Any edge trace is linear; mass by row sums."""

    nodes: ClassVar[Floats] = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    edges: ClassVar[tuple[tuple[int, ...], ...]] = ((0, 1), (1, 2), (2, 3), (3, 0))
    degree: ClassVar[int] = 1
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "row-sum"
    locks: ClassVar[bool] = True
    beyond: ClassVar[Mapping[str, str]] = {"quadratic shape functions": "q2", "freedom from locking": "q1-fbar"}

    def functions(self, points: Floats) -> Floats:
        """N_a = (1 + xi_a xi)(1 + eta_a eta)/4."""
        return 0.25 * (1.0 + points[:, :1] * self.nodes[:, 0]) * (1.0 + points[:, 1:] * self.nodes[:, 1])

    def quadrature(self) -> Quadrature:
        """2x2 Gauss points, counter-clockwise like the nodes."""
        return Quadrature(_G * self.nodes, np.ones(4))

    def block_kernels(self, kinematics: Kinematics) -> BlockKernels:
        """Hand-written kernels on the coefficients of the bilinear map (see `q1_kernels`)."""
        # steps without contact are 1.4 times faster than with the kernels that the core makes of the shape functions
        from contactlab_quads import q1_kernels

        return BlockKernels(q1_kernels.gradient, q1_kernels.force)
