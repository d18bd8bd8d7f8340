"""When an iteration has converged: residuals over scales that follow from the model itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Conditions, Floats, Response


class Residual(NamedTuple):
    """force: largest unbalanced nodal force over the largest nodal force; contact: largest violation of a
    condition in segment lengths."""

    force: float
    contact: float

    @property
    def largest(self) -> float:
        """The larger of the two residuals."""
        return max(self.force, self.contact)


def force_scale(parts: list[Floats], floor: float) -> float:
    """Largest component of any nodal force [N], not below `floor`."""
    return max(floor, *(float(np.abs(part).max(initial=0.0)) for part in parts))


def contact_residual(conditions: Conditions, response: Response) -> float:
    """Natural residual |C|/(c h): overlaps, gaps under pressure, slips of sticking and so on, in segment lengths."""
    c = conditions
    if not c.present.any():
        return 0.0
    scale = c.stiffness[c.present] * c.size[c.present]
    return float((np.abs(response.residual[:, c.present]) / scale).max())
