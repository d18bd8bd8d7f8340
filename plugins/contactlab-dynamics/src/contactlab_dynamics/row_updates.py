"""One condition at a time: the force that holds it while all others stay."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import section


@section
def normal_update(k, gap, size, work):
    """y >= 0, g >= 0, y g = 0 of row k at its present gap; returns its natural residual before and the change."""
    a, y = work[0, k], work[1, k]
    new = max(0.0, y - gap / a)
    work[1, k] = new
    return abs(min(gap, y * a)) / size[k], new - y


@section
def tangential_update(k, slip, size, measure, bound, work):
    """No slip, or the force at the friction bound; returns row k's residual before and the change of its force."""
    a, y = work[2, k], work[3, k]
    adhesion = bound[1, k] * measure[k]
    if bound[2, k] < np.inf:
        adhesion = min(adhesion, bound[2, k] * work[1, k])
    limit = bound[0, k] * work[1, k] + adhesion
    new = min(limit, max(-limit, y - slip / a))
    work[3, k] = new
    return abs(new - y) * a / size[k], new - y
