"""Gaps that the meshes have before the run, and that do not count as gaps, or not yet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from contactlab.api import Floats
from contactlab.kernels.contact.factored_rows import FAR


class StartGaps(ABC):
    """What of the gaps at the start is taken from the gaps of a step.

    value   (k,) [mm] gaps of the start, negative where surfaces overlap; zero where they count in full
    ramped  whether the share that counts grows during the run, so that contact puts energy in on purpose
    """

    ramped: ClassVar[bool]

    def __init__(self, value: Floats) -> None:
        self.value = value

    @abstractmethod
    def uncounted(self) -> float:
        """The share of the gaps of the start that does not count now, 0 to 1."""

    def take_from(self, gaps: Floats) -> None:
        """Take from the normal gaps (k, 2) [mm] what does not count."""
        gaps[:, 0] -= self.uncounted() * self.value


class RampedOverlap(StartGaps):
    """Overlaps of the start count as zero first, and come to count in full during a ramp.

    time  an array whose first number is the time [s] at which gaps are measured
    ramp  what counts of the overlaps at a time, 0 to 1
    """

    ramped = True

    def __init__(self, gaps: Floats, time: Floats, ramp: Callable[[float], float]) -> None:
        super().__init__(np.minimum(gaps, 0.0))
        self.time, self.ramp = time, ramp

    def uncounted(self) -> float:
        """Less with time."""
        return 1.0 - self.ramp(float(self.time[0]))


class ZeroStart(StartGaps):
    """Distances of the start, open or overlapping, count as gaps of zero all the time."""

    ramped = False

    def __init__(self, gaps: Floats) -> None:
        super().__init__(np.where(gaps < FAR, gaps, 0.0))  # where there was no condition, nothing is taken away

    def uncounted(self) -> float:
        """All of them."""
        return 1.0
