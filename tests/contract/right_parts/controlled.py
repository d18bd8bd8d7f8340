# kind integrator cls Controlled
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ExplicitIntegrator, StepControl


@dataclass(frozen=True)
class Controlled(ExplicitIntegrator):
    """Central differences whose steps follow the change of the acceleration, dt^2/12 of it.

    allowed  error of a step [mm]
    """

    allowed: float = 1e-6
    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2

    def control(self):
        return StepControl(order=3)

    def step(self, motion, dt):
        before = motion.acceleration()
        motion.kick(0.5 * (motion.last_dt + dt))
        motion.contact(ahead=dt)
        motion.drift(dt)
        change = motion.acceleration() - before
        return float(dt**2 / 12.0 * np.hypot(*change.T).max() / self.allowed)
