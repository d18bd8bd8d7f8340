"""Springs for implicit integrators, as plainly as an author would write them; one flaw or none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Conditions, ImplicitEnforcement, Response
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Exact(ImplicitEnforcement):
    """Closed gaps are zero: primal-dual active sets with friction."""

    flaw: str = ""
    asked: ClassVar[list[Any]] = []

    def respond(self, conditions: Conditions, out: Response) -> None:
        c = conditions
        k = np.where(c.present, c.stiffness, 0.0)
        trial = c.force[0] - k * c.gap
        closed = (trial > 0.0) | ((k == 0.0) & (self.flaw == "absent slots closed"))
        out.residual[0] = np.where(closed, k * c.gap, c.force[0])
        if self.flaw == "pulls":
            out.residual[0] = np.where(c.present, k * c.gap, c.force[0])
            closed = c.present
        if self.flaw == "leaves a thousandth":
            out.residual[0] = np.where(closed, k * (c.gap + 1e-3), c.force[0])
        out.by_force[0], out.by_gap[0] = np.where(closed, 0.0, 1.0), np.where(closed, k, 0.0)
        if self.flaw == "derivative of half the gap":
            out.by_gap[0] *= 0.5
        out.status[:] = np.where(closed, 2, 0)
        if self.flaw == "neighbours":
            out.residual[0, 1:] += 1e-9 * c.gap[:-1]
        if self.flaw == "writes gaps":
            c.gap[:] = np.maximum(c.gap, -0.5)
        if self.flaw == "status forgotten":
            out.status[0] = 5
        if len(out.residual) > 1:
            self._rub(c, k, np.maximum(trial, 0.0), closed, out)

    def _rub(self, c: Conditions, k: Any, normal: Any, closed: Any, out: Response) -> None:
        coefficient, adhesion, cap = c.bound * (1.1 if self.flaw == "rubs too much" else 1.0)
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


@dataclass(frozen=True)
class Slow(Exact):
    """Derivatives three times too large: Newton's method comes to its end, slowly."""

    def respond(self, conditions: Conditions, out: Response) -> None:
        super().respond(conditions, out)
        out.by_gap *= 3.0
        out.by_force *= 3.0


@hookimpl
def contactlab_parts() -> list[Part]:
    return [
        Part("enforcement", "numpy-active-set", "implicit_springs:Exact", "exact multipliers in plain NumPy"),
        Part("enforcement", "slow-active-set", "implicit_springs:Slow", "the same with derivatives too large"),
    ]
