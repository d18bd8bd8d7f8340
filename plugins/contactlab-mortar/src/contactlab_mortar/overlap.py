"""The overlap of a slave and a master segment: what is integrated, differentiated and reported comes from here."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.compiled.kernel import point
from contactlab_mortar.projection import edge_vector, master_parameter, slave_parameter

# cosines by which normals are opposed: flanks of a corner, below the first, are no partners; from the second on
# segments count in full, in between by a weight that grows evenly: one that turns joins without a jump
FLANK, FACING = 0.2, 0.3
SMALLEST = 1e-12  # overlaps shorter than this fraction of a slave segment carry nothing but round-off


class Overlap(NamedTuple):
    """Part of a slave segment that sees a master segment: xi and eta where it begins and where it ends."""

    low: float
    high: float
    eta_low: float
    eta_high: float


@point
def opposed(slave, master):
    """Cosine by which the normals of two segments are opposed, as the bodies lie on the left of both."""
    ex, ey, (fx, fy) = slave.ex, slave.ey, edge_vector(master)
    return -(ex * fx + ey * fy) / np.sqrt((ex * ex + ey * ey) * (fx * fx + fy * fy))


@point
def facing(slave, master):
    """Weight of what two segments share: 1 where they face each other, 0 where one is a flank."""
    ex, ey, (fx, fy) = slave.ex, slave.ey, edge_vector(master)
    along, sizes = ex * fx + ey * fy, (ex * ex + ey * ey) * (fx * fx + fy * fy)
    if along >= 0.0 or along * along <= FLANK * FLANK * sizes:
        return 0.0
    return 1.0 if along * along >= FACING * FACING * sizes else (opposed(slave, master) - FLANK) / (FACING - FLANK)


@point
def _ends(first, second):
    """Part of the slave segment between two parameters: low and high, high below low where there is none."""
    if np.isnan(first) or np.isnan(second):
        return 1.0, 0.0
    return max(0.0, min(first, second)), min(1.0, max(first, second))


@point
def _seen(xi, first, second, slave, master):
    """eta at an end xi of an overlap: a master node where the end is one, else where the normal meets the segment."""
    if xi == first:
        return 0.0
    if xi == second:
        return 1.0
    return min(1.0, max(0.0, master_parameter(xi, slave, master)))


@point
def overlap_between(first, second, slave, master):
    """Overlap where the ends of the master segment are seen from `first` and `second`; empty: see `is_empty`."""
    low, high = _ends(first, second)
    if not high - low > SMALLEST:
        return Overlap(1.0, 0.0, 0.0, 0.0)
    eta_low, eta_high = _seen(low, first, second, slave, master), _seen(high, first, second, slave, master)
    return Overlap(low, high, eta_low, eta_high)


@point
def overlap(slave, master):
    """Overlap of two segments, empty where they do not face each other."""
    if not facing(slave, master) > 0.0:
        return Overlap(1.0, 0.0, 0.0, 0.0)
    first = slave_parameter(slave, master.cx, master.cy)
    second = slave_parameter(slave, master.dx, master.dy)
    return overlap_between(first, second, slave, master)


@point
def is_empty(found):
    """Whether nothing of the slave segment sees the master segment."""
    return found.high < found.low
