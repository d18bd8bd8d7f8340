"""Hooke's law for small displacements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import UNIT, Material, formula
from contactlab_solids.elastic_constants import check_elastic, elastic_limit, lame


@dataclass(frozen=True)
class LinearElastic(Material):
    """Isotropic Hooke in plane strain, strain = sym(du/dX), forces on the undeformed geometry.

    young    Young's modulus [MPa]
    poisson  Poisson's ratio, -1 < poisson < 0.5
    density  [t/mm3]
    yield_stress  of the material [MPa]: not used, but a run that exceeds it warns
    """

    young: float
    poisson: float
    density: float
    yield_stress: float | None = None

    beyond: ClassVar[Mapping[str, str]] = {"finite strain": "neo-hookean", "plasticity": "linear-hardening"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density, self.yield_stress)

    def elastic_limit(self) -> float:
        """The yield stress [MPa]; inf if none is given."""
        return elastic_limit(self.yield_stress)

    @formula
    def stress(H: Any, p: Any) -> Any:
        """Compute sigma = lambda tr(eps) I + 2 mu eps."""
        first, shear = lame(p)
        return first * H.trace() * UNIT + 2.0 * shear * H.symmetric()

    @formula
    def energy(H: Any, p: Any) -> Any:
        """W = lambda/2 tr(eps)^2 + mu eps : eps per undeformed volume."""
        first, shear = lame(p)
        strain, trace = H.symmetric(), H.trace()
        return 0.5 * first * trace * trace + shear * strain.dot(strain)
