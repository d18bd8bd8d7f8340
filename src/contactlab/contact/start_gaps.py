"""Gaps that the meshes have before the run, and that do not count as gaps, or not yet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from contactlab.api import Floats
from contactlab.kernels.contact.pair import FAR


class StartGaps(ABC):
    """What of the gaps at the start is taken from the gaps of a step.

    value      (k,) [mm] gaps of the start, negative where surfaces overlap; zero where they count in full
    ramped     whether the scene asks for an overlap to be pushed out, so that contact puts energy in on purpose
    lasting    whether the gaps of the start never come to count
    by_facets  whether no node overlaps, and the facets alone make weighted gaps negative
    opened     by how much nodes of the slave were moved at most to open surfaces that touched [mm]
    """

    ramped: ClassVar[bool] = False
    lasting: ClassVar[bool] = False
    by_facets: ClassVar[bool] = False
    opened: float = 0.0

    def __init__(self, value: Floats) -> None:
        self.value = value

    @abstractmethod
    def uncounted(self) -> float:
        """The share of the gaps of the start that does not count now, 0 to 1."""

    def told(self) -> str:
        """What a run says of them at its start; empty where the scene has asked for them."""
        return ""


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


class FacetOverlap(RampedOverlap):
    """Weak overlaps of surfaces that only touch: facets make them, and they come to count in full during a ramp.

    The mean gap of a curved surface over the facets at a node lies h^2/12R below the gap of the node itself. To push
    that out in one step would be a blow, whose energy nothing supplied. Where nothing loads the bodies, the ramp has no
    end, and they keep their energy.
    """

    ramped, by_facets = False, True

    def told(self) -> str:
        """The amount, and what is done about it."""
        return (
            f"the facets of surfaces that touch overlap by up to {-float(self.value.min()):.3g} mm in their weighted "
            "gaps, and no node does: they count as touching, and the overlap comes to count as loads come"
        )

    def pushed(self, begin: float, end: float) -> Floats | None:
        """Gaps (k,) [mm] that come to count between two times [s], none above zero; None if there are none."""
        share = self.ramp(end) - self.ramp(begin)
        return share * self.value if share > 0.0 else None


class ZeroStart(StartGaps):
    """Distances of the start, open or overlapping, count as gaps of zero all the time."""

    lasting = True

    def __init__(self, gaps: Floats) -> None:
        super().__init__(np.where(gaps < FAR, gaps, 0.0))  # where there was no condition, nothing is taken away

    def uncounted(self) -> float:
        """All of them."""
        return 1.0


class FittedFacets(ZeroStart):
    """The part of gaps that facets of fitting curves cause: it never counts, the clearance of the curves does."""

    def told(self) -> str:
        """The amount."""
        return (
            f"the facets of curved sides that fit overlap by up to {-float(self.value.min()):.3g} mm in their weighted "
            "gaps, and no node lies within the other curve: the distances of the curves count in their place"
        )
