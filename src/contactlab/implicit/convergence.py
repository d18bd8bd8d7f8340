"""When an iteration has converged: residuals over scales that follow from the model itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Conditions, Floats, Response

LOOSER = 1e-3  # of a violated condition against an unbalanced force: equilibrium passes its error on to all nodes


class Residual(NamedTuple):
    """force: largest unbalanced nodal force over the largest nodal force; contact: largest violation of a
    condition, see `contact_residual`."""

    force: float
    contact: float

    @property
    def largest(self) -> float:
        """The larger of the two residuals."""
        return max(self.force, self.contact)


def force_scale(parts: list[Floats], floor: float) -> float:
    """Largest component of any nodal force [N], not below `floor`."""
    return max(floor, *(float(np.abs(part).max(initial=0.0)) for part in parts))


def contact_residual(conditions: Conditions, response: Response, force: float, exact: float) -> float:
    """Largest violation of a condition: overlaps, gaps under pressure, slips of sticking and so on.

    It is the larger of |C|/(c h), in segment lengths, and of a thousandth of |C|/force: under a small load a violation
    that is small against segments may stand for much of the contact force.

    force  [N] largest nodal force of the model, > 0
    exact  [mm] round-off of positions: gaps below it count as none beside forces
    """
    c = conditions
    if not c.present.any():
        return 0.0
    stiffness, left = c.stiffness[c.present], np.abs(response.residual[:, c.present])
    beyond = np.where(left > exact * stiffness, left, 0.0)
    return float(np.maximum(left / (stiffness * c.size[c.present]), LOOSER * beyond / force).max())
