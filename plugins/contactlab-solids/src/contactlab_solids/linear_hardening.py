"""J2 plasticity with linear isotropic hardening."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, Material, formula
from contactlab.api.compiled.late import late
from contactlab_solids import j2
from contactlab_solids.elastic_constants import check_elastic

PLASTIC = 3  # history row


@dataclass(frozen=True)
class LinearHardening(Material):
    """sigma_y = yield_stress + hardening * ep at finite strain (see `j2`).

    young         Young's modulus [MPa]
    poisson       Poisson's ratio, -1 < poisson < 0.5
    density       of the undeformed body [t/mm3]
    yield_stress  at the start [MPa]
    hardening     slope of the yield stress by the equivalent plastic strain [MPa]; 0: perfectly plastic
    """

    young: float
    poisson: float
    density: float
    yield_stress: float
    hardening: float = 0.0

    history_size: ClassVar[int] = 4
    history_names: ClassVar[tuple[str, ...]] = j2.HISTORY
    implicit_euler: ClassVar[bool] = True
    without: ClassVar[Mapping[str, str]] = {"plasticity": "neo-hookean"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density)
        if not self.yield_stress > 0.0:
            raise ValueError(f"yield_stress: got {self.yield_stress}, allowed: a stress > 0 [MPa]")
        if not self.hardening >= 0.0:
            raise ValueError(f"hardening: got {self.hardening}, allowed: a slope >= 0 [MPa] (softening is refused)")

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Bounds of the elastic moduli, as yielding only softens."""
        j2.stiffening(gradient, stress, j2.moduli(self.young, self.poisson), out)

    def flow_stress(self, plastic_strain: Floats) -> Floats:
        """Yield stress [MPa] after an equivalent plastic strain."""
        return np.asarray(self.yield_stress + self.hardening * plastic_strain)

    @formula
    def flow(plastic: Any, p: Any) -> Any:
        """Yield stress [MPa] and its slope."""
        return p.yield_stress + p.hardening * plastic, p.hardening

    @formula
    def stress(F: Any, history: Any, flow: Any, p: Any) -> Any:
        """Elastic trial and radial return."""
        return j2.returned(F, history, flow, p)

    def stress_by_hand(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Elastic trial and radial return for `gradient`, which is F^-1."""
        # 4 to 9 times faster: series for roots and logarithms, vectorised
        j2_kernels = late("contactlab_solids.j2_kernels")
        if new_history is not history:
            new_history[:] = history
        constants, flow = j2.moduli(self.young, self.poisson), (self.yield_stress, self.hardening)
        if j2.elastic_trial(gradient, new_history, stress, constants, (*flow, PLASTIC)):
            arguments = (gradient, new_history, stress, *constants, *flow)
            if j2_kernels.linear_return(*arguments):
                j2_kernels.far_linear_return(*arguments)

    @formula
    def energy(F: Any, history: Any, p: Any) -> Any:
        """Elastic energy per current volume."""
        return j2.stored(F, history, p)

    @formula
    def dissipation(F: Any, history: Any, p: Any) -> Any:
        """Plastic work so far, integral of sigma_y d(ep), per current volume."""
        plastic = history.equivalent_plastic_strain
        return (p.yield_stress + 0.5 * p.hardening * plastic) * plastic / F.det()
