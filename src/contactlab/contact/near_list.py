"""Near lists of segments of two surfaces that may meet, and their validity."""

from __future__ import annotations

from dataclasses import dataclass

from contactlab.api import Candidates, Floats, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.kernels.contact.search import largest_move, near_segments

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
