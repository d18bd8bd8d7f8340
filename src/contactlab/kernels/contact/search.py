"""Near lists: segments of two surfaces that may meet, by sort-and-sweep over bounding boxes, and their validity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.kernel import kernel
from contactlab.api.surface import Candidates, Surface, SurfacePositions

REACH = 2.0  # segment lengths: farther slave segments are left out of the integrals
SKIN = 0.5  # segment lengths that surfaces may move before the near lists are rebuilt


@dataclass
class Near:
    """A near list and its positions."""

    candidates: Candidates
    slave: Floats
    master: Floats

    @classmethod
    def of(cls, slave: Surface, master: Surface, slave_at: Floats, master_at: Floats, size: float) -> Near:
        """Build the list of surfaces whose nodes are at (m, 2) [mm], `size` being their longest segment."""
        reach = (REACH + 1.0) * size + 2.0 * SKIN * size
        found = near_segments(slave_at, slave.segments, master_at, master.segments, reach)
        return cls(found, slave_at.copy(), master_at.copy())

    def holds(self, at: SurfacePositions, size: float) -> bool:
        """Return whether nothing has moved so far that a segment might be missing."""
        skin = SKIN * size
        return not (largest_move(at.slave, self.slave) > skin or largest_move(at.master, self.master) > skin)


def longest_segment(at: SurfacePositions, slave: Surface, master: Surface) -> float:
    """Return the length [mm] of the longest segment of both surfaces."""
    return max(float(slave.lengths(at.slave).max()), float(master.lengths(at.master).max()))


@kernel
def take(values, index, out):
    """Copy rows `index` of values (N, 2) into out (m, 2)."""
    for i in range(index.size):
        out[i, 0] = values[index[i], 0]
        out[i, 1] = values[index[i], 1]


@kernel
def largest_move(now, before):
    """Return the largest absolute change of a coordinate between two (m, 2) arrays."""
    largest = 0.0
    for i in range(now.shape[0]):
        largest = max(largest, abs(now[i, 0] - before[i, 0]), abs(now[i, 1] - before[i, 1]))
    return largest


@kernel
def boxes(positions, segments, low, high):
    """Compute corners (s, 2) of the bounding box of every segment."""
    for s in range(segments.shape[0]):
        a, b = segments[s, 0], segments[s, 1]
        for i in range(2):
            low[s, i] = min(positions[a, i], positions[b, i])
            high[s, i] = max(positions[a, i], positions[b, i])


@kernel
def sweep(slave, master, axis, reach, start, found):
    """Count (found empty) or list the master boxes that overlap each slave box grown by `reach`.

    slave = (low, high) corners; master = (low, high, order along `axis`, width of the widest box along it)
    """
    slave_low, slave_high = slave
    low, high, order, widest = master
    other = 1 - axis
    count = 0
    listing = found.size > 0
    for s in range(slave_low.shape[0]):
        start[s] = count
        from_, to = slave_low[s, axis] - reach, slave_high[s, axis] + reach
        # the first box within the search distance of `from_`: boxes are sorted by their lower bound
        left, right = 0, order.size
        while left < right:
            middle = (left + right) // 2
            if low[order[middle], axis] < from_ - widest:
                left = middle + 1
            else:
                right = middle
        first = count
        while left < order.size and low[order[left], axis] <= to:
            m = order[left]
            left += 1
            if high[m, axis] < from_:
                continue
            if low[m, other] > slave_high[s, other] + reach or high[m, other] < slave_low[s, other] - reach:
                continue
            if listing:
                k = count  # insertion keeps every row ascending
                while k > first and found[k - 1] > m:
                    found[k] = found[k - 1]
                    k -= 1
                found[k] = m
            count += 1
    start[slave_low.shape[0]] = count
    return count


def near_segments(
    slave_positions: Floats, slave_segments: Ints, master_positions: Floats, master_segments: Ints, reach: float
) -> Candidates:
    """Return all pairs of segments whose boxes come within `reach` [mm] of each other."""
    slave = _bounds(slave_positions, slave_segments)
    low, high = _bounds(master_positions, master_segments)
    axis = int(np.argmax(high.max(axis=0) - low.min(axis=0)))
    order = np.argsort(low[:, axis], kind="stable").astype(np.int32)
    widest = float((high[:, axis] - low[:, axis]).max())
    start = np.zeros(len(slave_segments) + 1, np.int32)
    arguments = (slave, (low, high, order, widest), axis, reach, start)
    count = sweep(*arguments, np.zeros(0, np.int32))
    found = np.zeros(count, np.int32)
    if count:
        sweep(*arguments, found)
    return Candidates(start, found, reach)


def _bounds(positions: Floats, segments: Ints) -> tuple[Floats, Floats]:
    low, high = np.empty((len(segments), 2)), np.empty((len(segments), 2))
    boxes(positions, segments, low, high)
    return low, high
