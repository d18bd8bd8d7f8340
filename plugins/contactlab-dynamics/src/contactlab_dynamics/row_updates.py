"""Updates of single conditions: the force that holds each while all others stay. `rows` are `Rows` throughout.

rows.work holds what a solve keeps of each row: compliance and force, normal (0, 1) and tangential (2, 3).
"""

from __future__ import annotations

from contactlab.api.compiled.friction import friction_limit
from contactlab.api.compiled.kernel import section


@section
def normal_update(k, gap, rows):
    """y >= 0, g >= 0, y g = 0 of row k at its present gap; returns its natural residual before and the change."""
    a, y = rows.work[0, k], rows.work[1, k]
    new = max(0.0, y - gap / a)
    rows.work[1, k] = new
    return abs(min(gap, y * a)) / rows.size[k], new - y


@section
def tangential_update(k, slip, rows):
    """No slip, or the force at the friction bound; returns row k's residual before and the change of its force."""
    a, y = rows.work[2, k], rows.work[3, k]
    limit = friction_limit(rows.bound[0, k], rows.bound[1, k], rows.bound[2, k], rows.measure[k], rows.work[1, k])
    new = min(limit, max(-limit, y - slip / a))
    rows.work[3, k] = new
    return abs(new - y) * a / rows.size[k], new - y
