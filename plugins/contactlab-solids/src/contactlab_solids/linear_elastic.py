"""Hooke's law for small displacements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Floats, Kinematics, Material
from contactlab.api.compiled.late import late
from contactlab_solids.elastic_constants import check_elastic, elastic_limit, elastic_wave_speeds, lame_constants


@dataclass(frozen=True)
class LinearElastic(Material):
    """Isotropic Hooke in plane strain, strain = sym(du/dX), forces on the undeformed geometry.

    young    Young's modulus [MPa]
    poisson  Poisson's ratio, -1 < poisson < 0.5
    density  [t/mm3]
    yield_stress  where the material would yield [MPa]: not used, but a run that goes beyond it says so
    """

    young: float
    poisson: float
    density: float
    yield_stress: float | None = None

    kinematics: ClassVar[Kinematics] = "small"
    has_energy: ClassVar[bool] = True
    beyond: ClassVar[Mapping[str, str]] = {"finite strain": "neo-hookean", "plasticity": "linear-hardening"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density, self.yield_stress)

    def elastic_limit(self) -> float:
        """The yield stress [MPa]; inf where none is given."""
        return elastic_limit(self.yield_stress)

    def wave_speeds(self) -> tuple[float, float]:
        """Dilatational and shear speed [mm/s]."""
        return elastic_wave_speeds(self.young, self.poisson, self.density)

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Compute sigma = lambda tr(eps) I + 2 mu eps."""
        late("contactlab_solids.kernels").linear_elastic(gradient, stress, *lame_constants(self.young, self.poisson))

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """Fill in Hooke's constants, the same at every point."""
        lame, shear = lame_constants(self.young, self.poisson)
        tangent[:] = 0.0
        tangent[:3, 0] = tangent[:3, 3] = lame
        tangent[0, 0] += 2.0 * shear
        tangent[1, 3] += 2.0 * shear
        tangent[3, 1] = tangent[3, 2] = shear

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        """W = lambda/2 tr(eps)^2 + mu eps : eps per undeformed volume."""
        lame, shear = lame_constants(self.young, self.poisson)
        xx, yy, xy = gradient[0], gradient[3], 0.5 * (gradient[1] + gradient[2])
        energy[:] = 0.5 * lame * (xx + yy) ** 2 + shear * (xx**2 + yy**2 + 2.0 * xy**2)
