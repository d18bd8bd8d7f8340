"""Initial gaps of the meshes that do not count as gaps, or not yet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from contactlab.api import Floats
from contactlab.kernels.contact.pair import FAR


class StartGaps(ABC):
    """The share of initial gaps that is subtracted from the gaps of a step.

    value      (k,) [mm] initial gaps, negative if surfaces overlap; zero if they count in full
    ramped     True if the scene pushes an overlap out, so that contact adds energy on purpose
    lasting    True if the initial gaps never count
    by_facets  True if no node overlaps, and the facets alone make weighted gaps negative
    opened     largest motion of slave nodes that opened touching surfaces [mm]
    """

    ramped: ClassVar[bool] = False
    lasting: ClassVar[bool] = False
    by_facets: ClassVar[bool] = False
    opened: float = 0.0

    def __init__(self, value: Floats) -> None:
        self.value = value

    @abstractmethod
    def uncounted(self) -> float:
        """Return the share of the initial gaps that does not count now, 0 to 1."""

    def told(self) -> str:
        """Return the message of a run at its start; empty if the scene declares them."""
        return ""


class RampedOverlap(StartGaps):
    """Initial overlaps that count as zero first, and count in full after a ramp.

    time  an array whose first number is the time [s] at which gaps are measured
    ramp  share of the overlaps that counts at a time, 0 to 1
    """

    ramped = True

    def __init__(self, gaps: Floats, time: Floats, ramp: Callable[[float], float]) -> None:
        super().__init__(np.minimum(gaps, 0.0))
        self.time, self.ramp = time, ramp

    def uncounted(self) -> float:
        """Return the share, which falls with time."""
        return 1.0 - self.ramp(float(self.time[0]))


class FacetOverlap(RampedOverlap):
    """Weak overlaps of touching surfaces by their facets, which count in full after a ramp.

    The mean gap of a curved surface over the facets at a node lies h^2/12R below the gap of the node itself. Pushing
    it out in one step would be an impact with energy from nowhere. If nothing loads the bodies, the ramp has no
    end, and they keep their energy.
    """

    ramped, by_facets = False, True

    def told(self) -> str:
        """Return a message with the amount, and its treatment."""
        return (
            f"the facets of surfaces that touch overlap by up to {-float(self.value.min()):.3g} mm in their weighted "
            "gaps, and no node does: they count as touching, and the overlap comes to count as loads come"
        )

    def pushed(self, begin: float, end: float) -> Floats | None:
        """Return gaps (k,) [mm] that begin to count between two times [s], none above zero; None without any."""
        share = self.ramp(end) - self.ramp(begin)
        return share * self.value if share > 0.0 else None


class ZeroStart(StartGaps):
    """Initial distances, open or overlapping, that count as zero gaps all the time."""

    lasting = True

    def __init__(self, gaps: Floats) -> None:
        super().__init__(np.where(gaps < FAR, gaps, 0.0))  # without a constraint nothing is subtracted

    def uncounted(self) -> float:
        """Return 1: no initial gap counts."""
        return 1.0


class FittedFacets(ZeroStart):
    """Gaps by facets of matching curves: they never count, the clearance of the curves does."""

    def told(self) -> str:
        """Return a message with the amount."""
        return (
            f"the facets of curved sides that fit overlap by up to {-float(self.value.min()):.3g} mm in their weighted "
            "gaps, and no node lies within the other curve: the distances of the curves count instead"
        )
