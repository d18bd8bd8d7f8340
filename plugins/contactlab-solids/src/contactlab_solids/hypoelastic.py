"""Hooke's law in rate form: Cauchy stress with the Jaumann rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Floats, Kinematics, Material
from contactlab.api.compiled.late import late
from contactlab_solids.elastic_constants import check_elastic, elastic_limit, elastic_wave_speeds, lame_constants


@dataclass(frozen=True)
class Hypoelastic(Material):
    """Jaumann rate of the Cauchy stress = lambda tr(d) I + 2 mu d, on the current geometry.

    Integrated with the rotation of Hughes & Winget (1980), half of it before and half of it after the
    step's strain: rigid rotations are exact for any step, shear is second order. Large rotations, small
    elastic strains: the law has no stored energy, and a closed cycle of strain can leave work behind.

    young    Young's modulus [MPa]
    poisson  Poisson's ratio, -1 < poisson < 0.5
    density  of the undeformed body [t/mm3]
    yield_stress  where the material would yield [MPa]: not used, but a run that goes beyond it says so
    """

    young: float
    poisson: float
    density: float
    yield_stress: float | None = None

    kinematics: ClassVar[Kinematics] = "rate"
    history_size: ClassVar[int] = 4
    history_names: ClassVar[tuple[str, ...]] = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")
    without: ClassVar[Mapping[str, str]] = {"finite strain": "linear-elastic"}
    beyond: ClassVar[Mapping[str, str]] = {"plasticity": "linear-hardening"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density, self.yield_stress)

    def elastic_limit(self) -> float:
        """The yield stress [MPa]; inf where none is given."""
        return elastic_limit(self.yield_stress)

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds at zero stress [mm/s]."""
        return elastic_wave_speeds(self.young, self.poisson, self.density)

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Tension stiffens like a string, and the turning of a stress adds at most its principal difference."""
        mean, radius = 0.5 * (stress[0] + stress[1]), np.hypot(0.5 * (stress[0] - stress[1]), stress[3])
        _, shear = lame_constants(self.young, self.poisson)
        out[:] = 1.0 + (np.maximum(mean + radius, 0.0) + 2.0 * radius) / shear

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """sigma = R (R sigma_old R^T + lambda tr(d) I + 2 mu d) R^T, R R = Q; `gradient`: increment at mid-step."""
        if new_history is not history:
            new_history[:] = history
        late("contactlab_solids.hypoelastic_kernels").stress(
            gradient, new_history, stress, *lame_constants(self.young, self.poisson)
        )

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """d(stress row)/d(row of the increment gradient at mid-step), (4, 4, P)."""
        from contactlab_solids import hypoelastic_kernels

        hypoelastic_kernels.tangent(gradient, history, tangent, *lame_constants(self.young, self.poisson))
