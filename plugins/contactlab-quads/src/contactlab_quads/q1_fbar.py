"""The bilinear quadrilateral with one dilatation per cell, which does not lock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from contactlab.api import BlockKernels, Element, Floats, Kinematics
from contactlab_quads.q1 import Q1


@dataclass(frozen=True)
class Q1Fbar(Element):
    """Q1 whose points all see the volume change of the cell's centre.

    In-plane F scaled by (J0/J)^(1/2) for "finite" laws (de Souza Neto and others 1996), the increment's
    likewise for "rate" laws, the strain's trace replaced for "small" ones (B-bar). Forces are the
    conjugate ones, which keeps energy and makes the stiffness of elastic laws symmetric. The stable step is
    as for Q1.
    """

    nodes: ClassVar[Floats] = Q1.nodes
    edges: ClassVar[tuple[tuple[int, ...], ...]] = Q1.edges
    degree: ClassVar[int] = 1
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "row-sum"
    without: ClassVar[Mapping[str, str]] = {"freedom from locking": "q1"}
    beyond: ClassVar[Mapping[str, str]] = {"quadratic shape functions": "q2"}

    functions, quadrature = Q1.functions, Q1.quadrature

    def block_kernels(self, kinematics: Kinematics) -> BlockKernels:
        """The averaged gradient of these kinematics, and the forces conjugate to it."""
        from contactlab_quads import q1_fbar_kernels as kernels

        gradient = {
            "small": kernels.small_gradient,
            "finite": kernels.finite_gradient,
            "rate": kernels.rate_gradient,
        }[kinematics]
        return BlockKernels(gradient, kernels.force)
