"""Compressible neo-Hookean law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import UNIT, Floats, Material, formula
from contactlab.api.compiled.late import late
from contactlab_solids.elastic_constants import check_elastic, elastic_limit, lame, lame_constants


@dataclass(frozen=True)
class NeoHookean(Material):
    """W = mu/2 (tr C - 3 - 2 ln J) + lambda/2 (ln J)^2, plane strain, any strain.

    young    Young's modulus at small strain [MPa]
    poisson  Poisson's ratio at small strain, -1 < poisson < 0.5
    density  of the undeformed body [t/mm3]
    yield_stress  of the material [MPa]: not used, but a run that exceeds it warns
    """

    young: float
    poisson: float
    density: float
    yield_stress: float | None = None

    without: ClassVar[Mapping[str, str]] = {"finite strain": "linear-elastic"}
    beyond: ClassVar[Mapping[str, str]] = {"plasticity": "linear-hardening"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density, self.yield_stress)

    def elastic_limit(self) -> float:
        """The yield stress [MPa]; inf if none is given."""
        return elastic_limit(self.yield_stress)

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Spatial moduli are lambda/J and (mu - lambda ln J)/J; tension adds its largest principal stress."""
        # 6 times faster than the default, and at most twice as large
        lame, shear = lame_constants(self.young, self.poisson)
        inverse_j = gradient[0] * gradient[3] - gradient[1] * gradient[2]
        mean, half = 0.5 * (stress[0] + stress[1]), 0.5 * (stress[0] - stress[1])
        tension = np.maximum(mean + np.hypot(half, stress[3]), 0.0)
        # a folded point has no logarithm: the guards stop the run, the step only has to stay finite
        log_j = -np.log(np.maximum(inverse_j, 1e-12))
        shear_now = (shear - lame * log_j) * inverse_j + tension
        np.maximum(np.maximum(shear_now / shear, inverse_j), 1e-3, out=out)

    @formula
    def stress(F: Any, p: Any) -> Any:
        """sigma = [mu (b - I) + lambda ln J I]/J with b = F F^T."""
        first, shear = lame(p)
        J = F.det()
        return (shear * (F @ F.T() - UNIT) + first * math.log(J) * UNIT) / J

    def stress_by_hand(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Compute the stress of the formula. Called as `stress` on blocks, instead of the formula."""
        # 1.6 times faster: F^-1, which it is given, takes one division less
        late("contactlab_solids.kernels").neo_hookean(gradient, stress, *lame_constants(self.young, self.poisson))

    @formula
    def energy(F: Any, p: Any) -> Any:
        """W/J, the energy per current volume."""
        first, shear = lame(p)
        J, log_j = F.det(), math.log(F.det())
        return (0.5 * shear * ((F @ F.T()).trace() - 3.0 - 2.0 * log_j) + 0.5 * first * log_j * log_j) / J
