"""Compressible neo-Hookean law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Floats, Kinematics, Material
from contactlab.api.compiled.late import late
from contactlab_solids.elastic_constants import check_elastic, elastic_limit, elastic_wave_speeds, lame_constants


@dataclass(frozen=True)
class NeoHookean(Material):
    """W = mu/2 (tr C - 3 - 2 ln J) + lambda/2 (ln J)^2, plane strain, any strain.

    young    Young's modulus at small strain [MPa]
    poisson  Poisson's ratio at small strain, -1 < poisson < 0.5
    density  of the undeformed body [t/mm3]
    yield_stress  where the material would yield [MPa]: not used, but a run that goes beyond it says so
    """

    young: float
    poisson: float
    density: float
    yield_stress: float | None = None

    kinematics: ClassVar[Kinematics] = "finite"
    has_energy: ClassVar[bool] = True
    without: ClassVar[Mapping[str, str]] = {"finite strain": "linear-elastic"}
    beyond: ClassVar[Mapping[str, str]] = {"plasticity": "linear-hardening"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density, self.yield_stress)

    def elastic_limit(self) -> float:
        """The yield stress [MPa]; inf where none is given."""
        return elastic_limit(self.yield_stress)

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds at small strain [mm/s]."""
        return elastic_wave_speeds(self.young, self.poisson, self.density)

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Spatial moduli are lambda/J and (mu - lambda ln J)/J; tension adds its largest principal stress."""
        lame, shear = lame_constants(self.young, self.poisson)
        inverse_j = gradient[0] * gradient[3] - gradient[1] * gradient[2]
        mean, half = 0.5 * (stress[0] + stress[1]), 0.5 * (stress[0] - stress[1])
        tension = np.maximum(mean + np.hypot(half, stress[3]), 0.0)
        # a folded point has no logarithm: the guards stop the run, the step only has to stay finite
        log_j = -np.log(np.maximum(inverse_j, 1e-12))
        shear_now = (shear - lame * log_j) * inverse_j + tension
        np.maximum(np.maximum(shear_now / shear, inverse_j), 1e-3, out=out)

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """sigma = [mu (b - I) + lambda ln J I]/J with b = F F^T; `gradient` is F^-1."""
        late("contactlab_solids.kernels").neo_hookean(gradient, stress, *lame_constants(self.young, self.poisson))

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """d(stress row)/d(row of F^-1), (4, 4, P)."""
        from contactlab_solids import kernels

        kernels.neo_hookean_tangent(gradient, tangent, *lame_constants(self.young, self.poisson))

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        """W/J, the energy per current volume."""
        from contactlab_solids import kernels

        kernels.neo_hookean_energy(gradient, energy, *lame_constants(self.young, self.poisson))
