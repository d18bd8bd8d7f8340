"""The mortar method: contact in the mean over the functions of a multiplier space, on the slave (Baillet & Sassi 2005).

Two bodies touch along polygons whose nodes do not match. To ask of each slave node that it is not inside the master is
too much at some places and too little at others: a uniform pressure is not transmitted exactly. A mortar method asks in
the mean: with multipliers lambda = sum psi_j lambda_j on the slave, the gap between a point x of the slave and the
point y of the master that it sees is weighted by the functions psi_j. No weighted mean may be negative,

    integral of psi_j (x - y) . n  over the part of the slave that has a partner  >=  0      for every j,

and if it is zero lambda_j may be positive: it is the pressure. Positions are shape functions times nodal positions, so
the integrals are three matrices,

    D_ij = integral of N_i psi_j,   M_lj = integral of N_l psi_j,   T_ij = integral of hat_i psi_j,

of the slave's shape functions, of the master's at the point that is seen, and of the hats of the slave's nodes, by
which separations and pressures are reported. The core makes conditions, forces and tangents of them
(docs/theory/rows.md).

Two things are left to say, and each is a formula below. *Which part of a slave segment sees a master segment?* A slave
point looks along the normals of its nodes, each the average of the segments that meet there, interpolated between them:
this field is continuous, so the slave sees no point twice and leaves out none. *Which functions weigh the gap?* They
differ between P0, P1 and dual. Where parts begin and end, integrals have kinks; between these they are
polynomials, so Gauss points find them exactly, and forces of both sides are the same to round-off: an even pressure
passes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from contactlab.api import Overlap, SegmentContact, formula


@dataclass(frozen=True)
class _Mortar(SegmentContact):
    """Base of both multiplier spaces: the overlaps.

    multipliers  which nodes of quadratic slave edges carry them: "nodes" all, "vertices" nodes at ends of edges;
                 "auto" is all without friction and the ends with it (mortar-operators.md, quadratic edges)
    """

    @formula
    def overlap(slave: Any, master: Any) -> Any:
        """Overlap between the points whose normals meet both ends of the master segment.

        The point y is seen from x(xi) = a + xi e along n(xi) = n + xi m if (x(xi) - y) x n(xi) = 0: a quadratic in xi.
        """
        low, high = slave.between(slave.sees(master.start), slave.sees(master.end))
        return Overlap(low, high, slave.meets(master, low), slave.meets(master, high))


@dataclass(frozen=True)
class _Coned(_Mortar):
    """A choice for multipliers that are not biorthogonal to the hats: which mean of the pressure is never negative.

    cone  "weak" the one over each hat, "strong" the multiplier of each node itself (rows.md, the strong cone)
    """

    cone: Literal["weak", "strong"] = "weak"

    @property
    def lumped(self) -> bool:
        """The strong cone lumps hats in T."""
        return self.cone == "strong"


@dataclass(frozen=True)
class MortarP0(_Coned):
    """Multipliers constant on the cell of each slave node (Baillet & Sassi 2005, M_h^0; mortar-operators.md)."""

    merged_below: ClassVar[float] = 0.05

    @formula
    def basis(xi: Any) -> Any:
        """Give each end the half next to it."""
        return (1.0, 0.0) if xi < 0.5 else (0.0, 1.0)


@dataclass(frozen=True)
class MortarP1(_Coned):
    """Multipliers continuous and linear on slave segments (Baillet & Sassi 2005, M_h^1; mortar-operators.md)."""

    @formula
    def basis(xi: Any) -> Any:
        """Hats: T is the mass matrix of the slave, and pressures of neighbours are coupled."""
        return 1.0 - xi, xi


@dataclass(frozen=True)
class MortarDual(_Mortar):
    """Multipliers biorthogonal to the hats on what is covered (Wohlmuth 2000; mortar-operators.md)."""

    biorthogonal: ClassVar[bool] = True
    merged_below: ClassVar[float] = 0.45

    @formula
    def basis(xi: Any, covered: Any) -> Any:
        """2 - 3 xi and 3 xi - 1 on a segment that is covered all along: T is diagonal, each multiplier has a gap.

        The integral of N_i psi_j over what is covered, which has the middle m and the width w, vanishes unless i = j,
        and is then the integral of N_j.
        """
        middle, width = 0.5 * (covered.low + covered.high), covered.high - covered.low
        tilt = 12.0 * middle * (1.0 - middle) * (xi - middle) / (width * width)
        return 1.0 - middle - tilt, middle + tilt
