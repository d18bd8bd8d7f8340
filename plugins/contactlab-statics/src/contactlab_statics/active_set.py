"""Exact multipliers by a primal-dual active set, a semi-smooth Newton method on the saddle point problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from contactlab.api import Conditions, Floats, FrictionBound, ImplicitEnforcement, Response
from contactlab.api.frame import OPEN, SLIP, STICK

TOUCHING = 1e-9  # segment lengths


@dataclass(frozen=True)
class ActiveSet(ImplicitEnforcement):
    """y_n = max(0, y_n - c g), y_t = clip(y_t - c d, -bound, bound).

    The stiffness c that decides which condition is closed follows from the stiffness of the nodes; results do
    not depend on it.

    scale   factor on c [-]
    start   of friction if surfaces touch without a force yet: "slip" as under no friction, or "stick", for bodies
            that nothing but friction holds; it needs more iterations elsewhere
    forces  "consistent": normal forces act along the derivatives of the gaps, as explicit ones of that name do
            (docs/theory/contact-energy.md); in steps in time they make no energy and keep angular momentum, in statics
            they take more iterations; "frozen": along normals, by weights; "auto": consistent in steps in time, frozen
            in load steps; "conjugate" and "published" are older names
    """

    scale: float = 1.0
    start: Literal["slip", "stick"] = "slip"
    forces: Literal["auto", "consistent", "frozen", "conjugate", "published"] = "auto"

    def __post_init__(self) -> None:
        if not 0.0 < self.scale < float("inf"):
            raise ValueError(f"scale: got {self.scale}, allowed: a factor > 0")

    def respond(self, conditions: Conditions, out: Response) -> None:
        """Closed conditions require zero gap, open ones zero force, slipping ones the force of the bound."""
        stiffness = np.where(conditions.present, self.scale * conditions.stiffness, 0.0)
        gap = np.where(conditions.present, conditions.gap, 0.0)
        force = conditions.force[0]
        trial = np.maximum(force - stiffness * gap, 0.0)
        # surfaces that touch without a force yet are taken for closed: bodies may be held by nothing else
        closed = conditions.present & (force - stiffness * (gap - TOUCHING * conditions.size) > 0.0)
        out.residual[0] = np.where(closed, stiffness * gap, force)
        out.by_force[0] = np.where(closed, 0.0, 1.0)
        out.by_gap[0] = np.where(closed, stiffness, 0.0)
        out.status[:] = np.where(closed, SLIP, OPEN)
        if len(out.residual) > 1:
            _tangential(conditions, stiffness, trial, closed, self.start == "stick", out)


def _tangential(
    conditions: Conditions, stiffness: Floats, normal: Floats, closed: Floats, sticks: bool, out: Response
) -> None:
    measure = np.where(conditions.present, conditions.measure, 0.0)
    limit, growth = FrictionBound(*conditions.bound).limits(normal, measure)
    force = conditions.force[1]
    trial = force - stiffness * conditions.slip
    # a slip that would turn round within an iteration has met its solution in between: it sticks
    turns = (trial * force < 0.0) & (np.abs(trial) >= limit) & (limit > 0.0)
    # surfaces that touch without a force yet have not slid
    rests = np.logical_and(closed, (growth > 0.0) & (force == 0.0) & (trial == 0.0) & sticks)
    stick = conditions.present & ((np.abs(trial) < limit) | turns | rests)
    sign = np.sign(trial)
    out.residual[1] = np.where(stick, stiffness * conditions.slip, force - sign * limit)
    out.by_force[1] = np.where(stick, 0.0, 1.0)
    out.by_gap[1] = np.where(stick, stiffness, 0.0)
    follows = ~stick & closed
    out.cross_force[:] = np.where(follows, -sign * growth, 0.0)
    out.cross_gap[:] = np.where(follows, sign * growth * stiffness, 0.0)
    out.status[:] = np.where(stick, STICK, np.where(limit > 0.0, SLIP, out.status))
