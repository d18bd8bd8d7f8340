"""A normal law as implicit integrators see it: residuals of pressures, and exact friction under them."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from contactlab.api import Conditions, Floats, ImplicitEnforcement, Response
from contactlab.contact.pressure_store import PressureStore

OPEN, STICK, SLIP = 0, 1, 2


class PressureResponse(ImplicitEnforcement):
    """Residuals y_n - length * pressure(gap), and |y_t| <= bound."""

    exact: ClassVar[bool] = False

    def __init__(self, store: PressureStore) -> None:
        self.law, self.stiffness = store.law, store.stiffness
        self.pressure, self.slope = np.zeros_like(store.stiffness), np.zeros_like(store.stiffness)

    def respond(self, conditions: Conditions, out: Response) -> None:
        """See `contactlab.api.ImplicitEnforcement`."""
        c = conditions
        acts = c.present & (c.gap < self.law.begins())
        self.law.pressure(np.where(acts, c.gap, self.law.begins()), self.stiffness, c.size, self.pressure, self.slope)
        wish = np.where(acts, c.measure * self.pressure, 0.0)
        out.residual[0] = c.force[0] - wish
        out.by_force[0] = 1.0
        out.by_gap[0] = np.where(acts, -c.measure * self.slope, 0.0)
        out.status[:] = np.where(acts, SLIP, OPEN)
        if len(out.residual) > 1:
            _rub(c, out)


def _rub(c: Conditions, out: Response) -> None:
    """Sticking conditions do not slip, the others carry their bound."""
    stiffness = np.where(c.present, c.stiffness, 0.0)
    limit, growth = _limits(c)
    trial = c.force[1] - stiffness * c.slip
    # a force at one end of its bound that would jump to the other sticks first: Newton's method goes to and fro else
    turns = (trial * c.force[1] < 0.0) & (limit > 0.0)
    sticks = (np.abs(trial) < limit) | turns
    sign = np.sign(trial)
    out.residual[1] = np.where(sticks, stiffness * c.slip, c.force[1] - sign * limit)
    out.by_force[1] = np.where(sticks, 0.0, 1.0)
    out.by_gap[1] = np.where(sticks, stiffness, 0.0)
    out.cross_force[:] = np.where(sticks, 0.0, -sign * growth)
    out.cross_gap[:] = 0.0
    out.status[:] = np.where(sticks, STICK, np.where(limit > 0.0, SLIP, out.status))


def _limits(c: Conditions) -> tuple[Floats, Floats]:
    """Largest tangential force (k,) [N] under the present normal one, and its derivative by that."""
    coefficient, adhesion, cap = c.bound
    normal, grip = np.maximum(c.force[0], 0.0), adhesion * c.measure
    capped = np.where(np.isfinite(cap), cap, 0.0) * normal
    follows = np.isfinite(cap) & (capped < grip)
    held = np.where(c.present, np.where(follows, capped, grip) + coefficient * normal, 0.0)
    return held, np.where(c.force[0] > 0.0, coefficient + np.where(follows, cap, 0.0), 0.0)
