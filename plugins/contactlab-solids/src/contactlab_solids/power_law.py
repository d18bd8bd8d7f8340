"""J2 plasticity with Swift's power law of hardening."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Floats, Kinematics, Material
from contactlab.api.compiled.late import late
from contactlab_solids import j2
from contactlab_solids.elastic_constants import check_elastic, elastic_wave_speeds

RISE = 4  # history row: yield stress less that of the start


@dataclass(frozen=True)
class PowerLaw(Material):
    """sigma_y = strength * (prestrain + ep)^exponent at finite strain (see `j2`); Baillet & Sassi 2005, 5.3.

    Example of the paper: strength 348 MPa, prestrain 0.02, exponent 0.03.

    young      Young's modulus [MPa]
    poisson    Poisson's ratio, -1 < poisson < 0.5
    density    of the undeformed body [t/mm3]
    strength   K [MPa]
    prestrain  e0 > 0 [-]
    exponent   n, 0 <= n <= 1 [-]
    """

    young: float
    poisson: float
    density: float
    strength: float
    prestrain: float
    exponent: float

    kinematics: ClassVar[Kinematics] = "finite"
    history_size: ClassVar[int] = 5
    history_names: ClassVar[tuple[str, ...]] = (*j2.HISTORY, "yield_stress_rise")
    has_energy: ClassVar[bool] = True
    implicit_euler: ClassVar[bool] = True
    without: ClassVar[Mapping[str, str]] = {"plasticity": "neo-hookean"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density)
        if not self.strength > 0.0:
            raise ValueError(f"strength: got {self.strength}, allowed: a stress > 0 [MPa]")
        if not self.prestrain > 0.0:
            raise ValueError(f"prestrain: got {self.prestrain}, allowed: a strain > 0 (the yield stress starts there)")
        if not 0.0 <= self.exponent <= 1.0:
            raise ValueError(f"exponent: got {self.exponent}, allowed: 0 (no hardening) to 1 (linear)")

    def wave_speeds(self) -> tuple[float, float]:
        """Elastic speeds [mm/s]."""
        return elastic_wave_speeds(self.young, self.poisson, self.density)

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Bounds of the elastic moduli, as yielding only softens."""
        j2.stiffening(gradient, stress, j2.moduli(self.young, self.poisson), out)

    def flow_stress(self, plastic_strain: Floats) -> Floats:
        """Yield stress [MPa] after an equivalent plastic strain."""
        return np.asarray(self.strength * (self.prestrain + np.asarray(plastic_strain)) ** self.exponent)

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Elastic trial and radial return for `gradient`, which is F^-1."""
        j2_kernels = late("contactlab_solids.j2_kernels")
        if new_history is not history:
            new_history[:] = history
        constants, start = j2.moduli(self.young, self.poisson), self.strength * self.prestrain**self.exponent
        if j2.elastic_trial(gradient, new_history, stress, constants, (start, 1.0, RISE)):
            arguments = (gradient, new_history, stress, *constants, start, self.exponent, self.prestrain)
            if j2_kernels.power_return(*arguments):
                j2_kernels.far_power_return(*arguments, self.strength)

    def complete_history(self, history: Floats) -> None:
        """The rise of the yield stress follows from the plastic strain."""
        history[RISE] = self.flow_stress(history[j2.PLASTIC]) - self.strength * self.prestrain**self.exponent

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """d(stress row)/d(row of F^-1), (4, 4, P)."""
        from contactlab_solids import j2_tangent

        ended, spare = np.empty_like(history), np.empty((4, gradient.shape[1]))
        self.stress(gradient, history, dt, spare, ended)
        plastic = ended[j2.PLASTIC]
        slope = self.exponent * self.flow_stress(plastic) / (self.prestrain + plastic)
        step = plastic - history[j2.PLASTIC]
        j2_tangent.tangent(gradient, history, step, slope, tangent, *j2.moduli(self.young, self.poisson))

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        """Elastic energy per current volume."""
        j2.energy(gradient, history, j2.moduli(self.young, self.poisson), energy)

    def dissipation(self, gradient: Floats, history: Floats, dissipation: Floats) -> None:
        """Plastic work so far, integral of sigma_y d(ep), per current volume."""
        plastic, power = history[j2.PLASTIC], self.exponent + 1.0
        density = self.strength / power * ((self.prestrain + plastic) ** power - self.prestrain**power)
        j2.per_current_volume(gradient, density, dissipation)
