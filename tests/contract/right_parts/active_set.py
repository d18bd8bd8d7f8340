# kind enforcement cls Exact
from dataclasses import dataclass

import numpy as np

from contactlab.api import ImplicitEnforcement


@dataclass(frozen=True)
class Exact(ImplicitEnforcement):
    """Closed gaps are zero: primal-dual active sets with friction."""

    def respond(self, conditions, out):
        c = conditions
        k = np.where(c.present, c.stiffness, 0.0)
        trial = c.force[0] - k * c.gap
        closed = trial > 0.0
        out.residual[0] = np.where(closed, k * c.gap, c.force[0])
        out.by_force[0], out.by_gap[0] = np.where(closed, 0.0, 1.0), np.where(closed, k, 0.0)
        out.status[:] = np.where(closed, 2, 0)
        if len(out.residual) > 1:
            self.rub(c, k, np.maximum(trial, 0.0), closed, out)

    def rub(self, c, k, normal, closed, out):
        coefficient, adhesion, cap = c.bound
        capped = cap * normal < adhesion * c.measure
        limit = coefficient * normal + np.where(capped, cap * normal, adhesion * c.measure)
        limit = np.where(c.present, limit, 0.0)
        growth = coefficient + np.where(capped, cap, 0.0)
        trial = c.force[1] - k * c.slip
        stick = (np.abs(trial) < limit) | ((trial * c.force[1] < 0.0) & (np.abs(trial) >= limit) & (limit > 0.0))
        sign = np.sign(trial)
        out.residual[1] = np.where(stick, k * c.slip, c.force[1] - sign * limit)
        out.by_force[1], out.by_gap[1] = np.where(stick, 0.0, 1.0), np.where(stick, k, 0.0)
        follows = ~stick & closed
        out.cross_force[:] = np.where(follows, -sign * growth, 0.0)
        out.cross_gap[:] = np.where(follows, sign * growth * k, 0.0)
        out.status[:] = np.where(stick, 1, np.where(limit > 0.0, 2, out.status))
