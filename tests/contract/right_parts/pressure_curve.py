# kind enforcement cls Curve
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ImplicitEnforcement


@dataclass(frozen=True)
class Curve(ImplicitEnforcement):
    """Pressure (u L)^2 / L, u = 1 - gap/L, from L before contact on; springs of shear, whose bound falls with the slip.

    length  L [mm]
    step    [mm] slip of a step at which 0.4 of the bound has fallen by a factor e
    """

    length: float = 0.01
    step: float = 0.5
    exact: ClassVar[bool] = False
    pressure_before_contact: ClassVar[bool] = True
    length_scale: ClassVar[str] = "length"
    time_scale: ClassVar[str] = "step"

    def respond(self, conditions, out):
        c, length = conditions, self.length
        closing = np.where(c.present, np.maximum(length - c.gap, 0.0), 0.0) / length
        out.residual[0] = c.force[0] - c.measure * length * closing**2
        out.by_force[0], out.by_gap[0] = 1.0, c.measure * 2.0 * closing
        out.status[:] = np.where(closing > 0.0, 2, 0)
        if len(out.residual) > 1:
            self.rub(c, out)

    def rub(self, c, out):
        coefficient, adhesion, cap = c.bound
        normal = np.maximum(c.force[0], 0.0)
        capped = cap * normal < adhesion * c.measure
        limit = coefficient * normal + np.where(capped, cap * normal, adhesion * c.measure)
        limit = np.where(c.present, limit, 0.0)
        growth = np.where(c.present & (c.force[0] > 0.0), coefficient + np.where(capped, cap, 0.0), 0.0)
        fall = 0.4 * np.exp(-((c.slip / self.step) ** 2))
        share, by_slip = 0.6 + fall, -2.0 * c.slip / self.step**2 * fall
        stiff = 100.0 * c.stiffness
        trial = c.force[1] + (c.anchor[1] - stiff * c.slip - c.force[1]) / 100.0
        sticks = c.present & (np.abs(trial) < limit * share)
        sign = np.sign(trial)
        out.residual[1] = c.force[1] - np.where(sticks, c.anchor[1] - stiff * c.slip, sign * limit * share)
        out.by_force[1], out.by_gap[1] = 1.0, np.where(sticks, stiff, -sign * limit * by_slip)
        out.cross_force[:], out.cross_gap[:] = np.where(sticks, 0.0, -sign * growth * share), 0.0
        out.status[:] = np.where(sticks, 1, np.where(limit > 0.0, 2, out.status))
