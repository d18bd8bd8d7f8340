"""The bilinear quadrilateral with one point and hourglass control."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from contactlab.api import BlockKernels, Element, Floats, Ints, Kinematics, Quadrature
from contactlab_quads.q1 import Q1


@dataclass(frozen=True)
class Q1Reduced(Element):
    """Q1 integrated at its centre; stiffness against the two hourglass modes (Flanagan & Belytschko 1981).

    The modes are measured on the undeformed cell, so their forces are exactly elastic and turn with it. The
    stiffness is taken from the shear modulus: scaled by lambda + 2 mu it would lock near poisson = 0.5.

    hourglass  stiffness of the modes over the shear modulus [-]; 0.035 to 0.18 is 1 to 5 % of lambda + 2 mu at
               poisson = 0.3. The energy balance has their energy as numerical: judge it there.
    """

    hourglass: float = 0.1

    nodes: ClassVar[Floats] = Q1.nodes
    edges: ClassVar[tuple[tuple[int, ...], ...]] = Q1.edges
    degree: ClassVar[int] = 1
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "row-sum"
    beyond: ClassVar[Mapping[str, str]] = {"full integration": "q1", "quadratic shape functions": "q2"}

    def __post_init__(self) -> None:
        if not self.hourglass > 0.0:
            raise ValueError(f"hourglass: got {self.hourglass}, allowed: a factor > 0, or the element has free modes")

    functions = Q1.functions

    def quadrature(self) -> Quadrature:
        """Rule of one point, the centre, with the whole weight."""
        return Quadrature(np.zeros((1, 2)), np.array([4.0]))

    def block_kernels(self, kinematics: Kinematics) -> BlockKernels:
        """Kernels of one point per cell, and the stage that stabilises hourglass modes."""
        from contactlab_quads import q1_reduced_kernels as kernels

        factor = self.hourglass

        def stabilise(
            reference: Floats, displacement: Floats, connectivity: Ints, shear: float, force: Floats, scratch: Floats
        ) -> None:
            kernels.stabilise(reference, displacement, connectivity, factor * shear, force, scratch)

        return BlockKernels(kernels.gradient, kernels.force, stabilise)
