"""The model for explicit integrators."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from contactlab.api import ExplicitIntegrator
from contactlab.api.integrator import LEAPFROG
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.contact.explicit_system import ContactSystem
    from contactlab.model.loading.effect_rates import EffectRates


@dataclass
class ExplicitModel(Model):
    """Implements `contactlab.api.ExplicitEquations`."""

    contact: ContactSystem | None
    integrator: ExplicitIntegrator

    explicit: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        leaps = self.integrator.velocity_lag == LEAPFROG
        self._before = None if self.increment is None or leaps else self.state["displacement"].copy()

    def rates(self, stable: float) -> EffectRates:
        """Return the rates of the effects, and of contact pressures."""
        rates = super().rates(stable)
        more = 0.0 if self.contact is None else self.contact.rate(stable)
        return replace(rates, square=rates.square + more) if more else rates

    def moved_back(self) -> None:
        """Take the displacement of a restored state as the start of the next step."""
        if self._before is not None:
            self._before[:] = self.state["displacement"]

    def _follow(self, dt: float) -> None:
        if self._before is None:
            np.multiply(self.state["velocity"], dt, out=self.increment)
        else:
            np.subtract(self.state["displacement"], self._before, out=self.increment)
            self._before[:] = self.state["displacement"]

    def lagging_work(self) -> float:
        """Return the work of the stresses [mJ] between the times of velocities and positions."""
        lag = self.integrator.velocity_lag * self.state.last_dt
        return lag * float(np.vdot(self.state["velocity"], self.state["internal_force"]))
