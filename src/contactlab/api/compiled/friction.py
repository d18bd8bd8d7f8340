"""The bound of friction of one condition, in kernels; of arrays it is `contactlab.api.FrictionBound.limits`."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import section


@section
def friction_limit(coefficient, adhesion, cap, measure, normal):
    """Largest tangential force [N] under a normal one [N] >= 0 of a condition that stands for `measure` [mm]."""
    grip = adhesion * measure
    if cap < np.inf:
        grip = min(grip, cap * normal)
    return coefficient * normal + grip
