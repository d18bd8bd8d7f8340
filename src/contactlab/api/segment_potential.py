"""Contact by an energy of the gap between two segments, by three formulas; neither side is the slave."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.compiled.late import late
from contactlab.api.formulas import array_method, declare, formulas_of
from contactlab.api.potential import NodalForces, Potential, PotentialView
from contactlab.api.segments import SideSegment
from contactlab.api.tensors import Number, Vector

_ARGUMENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "normal": ("own", "other", "p"),
    "overlap": ("own", "other", "p"),
    "energy": ("gap", "stiffness", "p"),
}
_FORMULAS: Final = "contactlab.formulas.segment_potentials"


@dataclass(frozen=True)
class SegmentPotential(Potential):
    """Energy of the gaps of both surfaces: the mean of its integrals over either, over undeformed lengths.

        normal(own, other)       unit vector along which points of two segments are matched, out of the body of `own`
        overlap(own, other)      the part of `own` that is integrated: low and high, xi from 0 to 1
        energy(gap, stiffness)   energy [mJ/mm2] of a gap [mm] along this normal, negative where surfaces overlap

    Each segment of one side meets each of the other that faces it, first as `own`, then as `other`; both are
    `SideSegment`s that run the same way. `stiffness` [MPa/mm] belongs to the cells behind: the dilatational modulus
    over the depth of a cell, both sides in series. Each formula may also ask for p, the numbers among the fields.
    The core finds the pairs, integrates by Gauss points over what is closer than `begins`, and differentiates twice,
    exactly. Quadratic edges are two segments each, which enclose the same area. Where nothing but a touch is left the
    energy is integrated as if surfaces pressed: what lies on something is held from the start.

    Friction is Coulomb's, smoothed, at the Gauss points, for the pressure minus d(energy)/d(gap).

    slip    [-] slip over the shortest undeformed segment up to which friction grows to its bound, in a step of a
            tenth of the loading or time
    points  Gauss points on each part: energies of degree 2 points - 1 in the gap are integrated exactly
    """

    slip: float = 5e-4

    points: ClassVar[int] = 2
    rubs: ClassVar[bool] = True

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        declare(cls, _ARGUMENTS)
        if "energy" in formulas_of(cls):
            cls.energy = array_method(SegmentPotential.energy, _FORMULAS, "energy")  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        if not 0.0 < self.slip < np.inf:
            raise ValueError(f"slip: got {self.slip}, allowed: above 0, finite")

    @staticmethod
    @abstractmethod
    def normal(own: SideSegment, other: SideSegment) -> Vector:
        """Return the unit vector along which points are matched, out of the body of `own`. A formula."""

    @staticmethod
    @abstractmethod
    def overlap(own: SideSegment, other: SideSegment) -> tuple[Number, Number]:
        """Return the part of `own` that is integrated, low and high; none if low is not below high. A formula."""

    def begins(self, view: PotentialView) -> float:
        """Return the gap [mm] beyond which there is no energy; 0, the default, for energies of overlaps alone."""
        return 0.0

    @abstractmethod
    def energy(self, view: PotentialView, positions: Floats) -> float:
        """Return the energy of all parts. In the body of a plugin component, a formula: energy(gap, stiffness, p)."""

    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Return the derivative of the energy, by dual numbers."""
        return np.asarray(late(_FORMULAS).gradient(self, view, positions))

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Return the second derivative, by dual numbers that change; None in plain Python."""
        return late(_FORMULAS).hessian(self, view, positions)

    def largest_step(self, view: PotentialView, positions: Floats, displacement: Floats) -> float:
        """Return the fraction after which no vertex is too deep: more would press too much."""
        return float(late(_FORMULAS).largest_step(self, view, positions, displacement))

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Return Coulomb friction of the points that are matched at the lagged positions, smoothed."""
        return np.asarray(late(_FORMULAS).friction_gradient(self, view, positions))

    def friction_hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Return the derivative of friction by the slip."""
        return late(_FORMULAS).friction_hessian(self, view, positions)

    def nodal_forces(self, view: PotentialView, positions: Floats) -> NodalForces:
        """Return forces on the vertices of the slave's polygon."""
        return NodalForces(*late(_FORMULAS).nodal_forces(self, view, positions))
