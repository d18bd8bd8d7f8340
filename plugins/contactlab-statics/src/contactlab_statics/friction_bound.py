"""Friction bounds of conditions (`contactlab.api.FrictionBound`), and how they grow with the normal force."""

from __future__ import annotations

import numpy as np

from contactlab.api import Conditions, Floats


def limits(conditions: Conditions, normal: Floats) -> tuple[Floats, Floats]:
    """Bound [N] of |y_t| at normal forces (k,) [N] >= 0, and its derivative by them."""
    coefficient, adhesion, cap = conditions.bound
    adhesive = np.where(conditions.present, adhesion * conditions.measure, 0.0)
    # inf times no force is a bound that does not ask whether the surface is pressed
    rising = np.where(np.isfinite(cap), np.where(np.isfinite(cap), cap, 0.0) * normal, np.inf)
    capped = rising < adhesive
    limit = coefficient * normal + np.where(capped, rising, adhesive)
    return limit, coefficient + np.where(capped, cap, 0.0)
