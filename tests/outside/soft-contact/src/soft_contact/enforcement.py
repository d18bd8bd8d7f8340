"""Contact as smooth springs: y_n = e w ln(1 + exp(-g/w)), with friction y_t = clip(a_t - e d, bound).

Far open the force falls exponentially, far closed it is that of a penalty; there is no kink for Newton's method.
Whether a condition sticks is asked of y_t - k (d - (a_t - y_t)/e), with the stiffness k of the nodes: of a_t - e d
alone Newton's method would go to and fro between both ends of the bound, as springs e are far stiffer than what they
hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Conditions, Floats, ImplicitEnforcement, Response

NOTHING = 40.0  # widths open at which no force is left: exp(-40) is below round-off


@dataclass(frozen=True)
class Soft(ImplicitEnforcement):
    """Springs without a kink.

    factor  stiffness e over that of the nodes in contact [-]
    width   w, length over which a spring begins to act, over that of the slave's segments [-]
    """

    exact: ClassVar[bool] = False  # gaps close up to what the springs give way
    factor: float = 200.0
    width: float = 1e-4

    def __post_init__(self) -> None:
        for name in ("factor", "width"):
            if not 0.0 < getattr(self, name) < float("inf"):
                raise ValueError(f"{name}: got {getattr(self, name)}, allowed: above 0, and finite")

    def respond(self, conditions: Conditions, out: Response) -> None:
        """Residuals y - y(gap), and with friction y_t - y_t(slip, y_n)."""
        c, e = conditions, np.where(conditions.present, self.factor * conditions.stiffness, 0.0)
        width = np.where(c.present, self.width * c.size, 1.0)
        closing = np.where(c.present, np.clip(-c.gap / width, -NOTHING, None), -NOTHING)
        acts = closing > -NOTHING
        wish = np.where(acts, e * width * np.logaddexp(0.0, closing), 0.0)
        out.residual[0] = c.force[0] - wish
        out.by_force[0] = 1.0
        out.by_gap[0] = np.where(acts, e / (1.0 + np.exp(-np.minimum(closing, NOTHING))), 0.0)
        out.status[:] = np.where(c.present & (c.gap < 0.0), 2, 0)
        if len(out.residual) > 1:
            self._rub(c, e, out)

    @staticmethod
    def _rub(c: Conditions, e: Floats, out: Response) -> None:
        limit, growth = _limit(c)
        spring = c.anchor[1] - e * c.slip
        trial = c.force[1] + np.divide(c.stiffness, e, out=np.zeros_like(e), where=e > 0.0) * (spring - c.force[1])
        sticks = c.present & (np.abs(trial) < limit)
        sign = np.sign(trial)
        out.residual[1] = c.force[1] - np.where(sticks, spring, sign * limit)
        out.by_force[1] = 1.0
        out.by_gap[1] = np.where(sticks, e, 0.0)
        out.cross_force[:] = np.where(sticks, 0.0, -sign * growth)
        out.cross_gap[:] = 0.0
        out.status[:] = np.where(sticks, 1, out.status)


def _limit(c: Conditions) -> tuple[Floats, Floats]:
    """Largest tangential force (k,) under the present normal one, and its derivative by that."""
    coefficient, adhesion, cap = c.bound
    normal, grip = np.maximum(c.force[0], 0.0), adhesion * c.measure
    capped = np.where(np.isfinite(cap), cap, 0.0) * normal
    follows = np.isfinite(cap) & (capped < grip)
    held = np.where(c.present, np.where(follows, capped, grip) + coefficient * normal, 0.0)
    return held, np.where(c.force[0] > 0.0, coefficient + np.where(follows, cap, 0.0), 0.0)
