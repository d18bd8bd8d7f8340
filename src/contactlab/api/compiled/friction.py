"""The friction bound of one constraint, in kernels; for arrays see `contactlab.api.FrictionBound.limits`."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import section

STICKS = 1.0 - 1e-5  # of the bound: upper limit of the friction force in stick; iterations end 1e-6 from a bound


@section
def friction_limit(coefficient, adhesion, cap, measure, normal):
    """Return the largest tangential force [N] under a normal force [N] >= 0 of a constraint, `measure` [mm] long."""
    grip = adhesion * measure
    if cap < np.inf:
        grip = min(grip, cap * normal)
    return coefficient * normal + grip
