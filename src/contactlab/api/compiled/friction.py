"""The friction bound of one constraint, in kernels; for arrays see `contactlab.api.FrictionBound.limits`."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import section


@section
def friction_limit(coefficient, adhesion, cap, measure, normal):
    """Return the largest tangential force [N] under a normal force [N] >= 0 of a constraint, `measure` [mm] long."""
    grip = adhesion * measure
    if cap < np.inf:
        grip = min(grip, cap * normal)
    return coefficient * normal + grip
