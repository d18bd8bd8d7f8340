"""Functions of one variable, by which loads, supports and fields vary from place to place or in time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from contactlab.api.arrays import Floats


class Function(ABC):
    """A factor at each place, or at each time. Subclasses are frozen dataclasses; their fields are the TOML keys."""

    @abstractmethod
    def values(self, at: Floats) -> Floats:
        """Return factors (n,) [-] at `at` (n,): coordinates or arc lengths [mm], angles [degree], or times [s].

        Finite for every finite number; each depends on its own entry of `at` alone.
        """

    def breaks(self) -> tuple[float, ...]:
        """Return places or times with a jump of value or slope. Integrals are split and load increments end there."""
        return ()

    def end(self) -> float:
        """Return the place or time after which the value is constant; infinite if it always changes."""
        return math.inf
