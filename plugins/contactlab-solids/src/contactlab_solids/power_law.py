"""J2 plasticity with Swift's power law of hardening."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, Material, formula
from contactlab.api.compiled.late import late
from contactlab_solids import j2
from contactlab_solids.elastic_constants import check_elastic

RISE = 4  # history row: yield stress less its initial value


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

    history_size: ClassVar[int] = 5
    history_names: ClassVar[tuple[str, ...]] = (*j2.HISTORY, "yield_stress_rise")
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

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Bounds of the elastic moduli, as yielding only softens."""
        j2.stiffening(gradient, stress, j2.moduli(self.young, self.poisson), out)

    def flow_stress(self, plastic_strain: Floats) -> Floats:
        """Yield stress [MPa] after an equivalent plastic strain."""
        return np.asarray(self.strength * (self.prestrain + np.asarray(plastic_strain)) ** self.exponent)

    @formula
    def flow(plastic: Any, p: Any) -> Any:
        """Yield stress [MPa] and its slope."""
        strength = p.strength * (p.prestrain + plastic) ** p.exponent
        return strength, p.exponent * strength / (p.prestrain + plastic)

    @formula
    def stress(F: Any, history: Any, flow: Any, p: Any) -> Any:
        """Elastic trial and radial return."""
        stress, new = j2.returned(F, history, flow, p)
        return stress, (*new, flow(new[3], p)[0] - flow(0.0, p)[0])

    def stress_by_hand(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Elastic trial and radial return for `gradient`, which is F^-1."""
        # 12 times faster: series for roots, powers and logarithms, vectorised
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
        history[RISE] = self.flow_stress(history[3]) - self.strength * self.prestrain**self.exponent

    @formula
    def energy(F: Any, history: Any, p: Any) -> Any:
        """Elastic energy per current volume."""
        return j2.stored(F, history, p)

    @formula
    def dissipation(F: Any, history: Any, p: Any) -> Any:
        """Plastic work so far, integral of sigma_y d(ep), per current volume."""
        power, plastic = p.exponent + 1.0, p.prestrain + history.equivalent_plastic_strain
        return p.strength / power * (plastic**power - p.prestrain**power) / F.det()
