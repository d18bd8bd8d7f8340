"""Which segments of two surfaces may meet, and how long that list is good for."""

from __future__ import annotations

from dataclasses import dataclass

from contactlab.api import Candidates, Floats, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.kernels.contact.search import largest_move, near_segments

REACH = 2.0  # segment lengths: farther slave segments are left out of the integrals
SKIN = 0.5  # segment lengths that surfaces may move before the near lists are made anew


@dataclass
class Near:
    """A near list and the positions it was made for."""

    candidates: Candidates
    slave: Floats
    master: Floats

    @classmethod
    def of(cls, slave: Surface, master: Surface, slave_at: Floats, master_at: Floats, size: float) -> Near:
        """The list of surfaces whose nodes are at (m, 2) [mm], `size` being their longest segment."""
        reach = (REACH + 1.0) * size + 2.0 * SKIN * size
        found = near_segments(slave_at, slave.segments, master_at, master.segments, reach)
        return cls(found, slave_at.copy(), master_at.copy())

    def holds(self, at: SurfacePositions, size: float) -> bool:
        """Whether nothing has moved so far that a segment might be missing."""
        skin = SKIN * size
        return not (largest_move(at.slave, self.slave) > skin or largest_move(at.master, self.master) > skin)


def longest_segment(at: SurfacePositions, slave: Surface, master: Surface) -> float:
    """Length [mm] of the longest segment of either surface."""
    return max(float(slave.lengths(at.slave).max()), float(master.lengths(at.master).max()))
