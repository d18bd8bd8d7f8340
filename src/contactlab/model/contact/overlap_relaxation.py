"""How distances that the meshes have before the run come to count, or do not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api import Floats
from contactlab.kernels.contact.factored_rows import FAR


class OverlapRelaxation:
    """Overlaps of the start count as zero first, and come to count in full during a ramp.

    overlap  (k,) [mm] gaps of the start where they are negative, else zero
    time     an array whose first number is the time [s] at which gaps are measured
    ramp     what counts of the overlaps at a time, 0 to 1
    """

    def __init__(self, overlap: Floats, time: Floats, ramp: Callable[[float], float]) -> None:
        self.overlap, self.time, self.ramp = np.minimum(overlap, 0.0), time, ramp

    def relax(self, gaps: Floats) -> None:
        """Take from the normal gaps (k, 2) what does not count yet."""
        gaps[:, 0] -= (1.0 - self.ramp(float(self.time[0]))) * self.overlap


class StartDistance:
    """Distances of the start, open or overlapping, count as gaps of zero all the time.

    distance  (k,) [mm] gaps of the start; where there was no condition, nothing is taken away
    """

    def __init__(self, gaps: Floats) -> None:
        self.distance = np.where(gaps < FAR, gaps, 0.0)

    def relax(self, gaps: Floats) -> None:
        """Take the distances of the start from the normal gaps (k, 2)."""
        gaps[:, 0] -= self.distance
