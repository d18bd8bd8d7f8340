"""Penalty and augmented Lagrangian: contact as springs, so that comparisons show what exact multipliers buy.

    y_n = max(0, a_n - e g),   y_t = clip(a_t - e d, -bound(y_n), +bound(y_n))

with the stiffness e, `factor` times the nodal stiffness in contact (`contactlab.api.Conditions.stiffness`). The anchor
a is zero for penalty (tangentially the force at the start of the step); an augmented Lagrangian makes the forces of a
converged iteration its next anchor until gaps and slips match exact multipliers.

In steps in time the stiffness of nodes has their inertia over the step in it. Springs of a `factor` of at least 1 hold
gaps as multipliers do, with impulses that make velocities fit (docs/statics.md); softer ones lose energy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from contactlab.api import Conditions, Floats, ImplicitEnforcement, Response
from contactlab_statics.active_set import ActiveSet

EXACT = ActiveSet()


@dataclass(frozen=True)
class Penalty(ImplicitEnforcement):
    """Springs as stiff as the bodies' nodes, times `factor`: surfaces overlap by about their deflection over it.

    factor  stiffness over the stiffness of the nodes in contact [-]
    """

    exact: ClassVar[bool] = False
    factor: float = 100.0

    def __post_init__(self) -> None:
        _refuse_factor(self.factor)

    @property
    def stores(self) -> bool:
        """Return whether springs are softer than the nodes: stiffer springs stop them within a step."""
        return self.factor < 1.0

    def respond(self, conditions: Conditions, out: Response) -> None:
        """Answer gaps and slips with springs, along the normal without memory."""
        springs(conditions, self.factor, np.zeros_like(conditions.gap), out)


@dataclass(frozen=True)
class AugmentedLagrangian(ImplicitEnforcement):
    """Springs whose forces are taken over again and again, until gaps match exact multipliers (Uzawa).

    factor  stiffness over the stiffness of the nodes in contact [-]; it decides how often, not the result
    """

    augments: ClassVar[bool] = True
    factor: float = 100.0

    def __post_init__(self) -> None:
        _refuse_factor(self.factor)

    def respond(self, conditions: Conditions, out: Response) -> None:
        """Answer gaps and slips with springs, along the normal without memory."""
        springs(conditions, self.factor, conditions.anchor[0], out)


def _refuse_factor(factor: float) -> None:
    if not 0.0 < factor < float("inf"):
        raise ValueError(f"factor: got {factor}, allowed: a factor > 0")


def springs(conditions: Conditions, factor: float, anchor: Floats, out: Response) -> None:
    """Fill `out` for springs with normal forces `anchor` (k,) [N] at zero gap.

    Springs are exact multipliers of the gaps g + (y - a)/e and slips d + (y_t - a_t)/e: states are decided alike, so
    that stiff springs need no more iterations than none.
    """
    softness = np.where(conditions.present, 1.0 / (factor * conditions.stiffness), 0.0)
    gap = conditions.gap + softness * (conditions.force[0] - anchor)
    slip = conditions.slip
    if len(conditions.force) > 1:
        slip = slip + softness * (conditions.force[1] - conditions.anchor[1])
    EXACT.respond(replace(conditions, gap=gap, slip=slip), out)
    out.by_force += out.by_gap * softness
    if len(conditions.force) > 1:
        out.cross_force += out.cross_gap * softness
