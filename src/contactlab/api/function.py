"""Functions of one variable, by which loads, supports and fields vary from place to place or in time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from contactlab.api.arrays import Floats


class Function(ABC):
    """A factor at each place, or at each time. Subclasses are frozen dataclasses; their fields are the TOML keys."""

    @abstractmethod
    def values(self, at: Floats) -> Floats:
        """Factors (n,) [-] at `at` (n,): coordinates or arc lengths [mm], angles [degree], or times [s].

        Finite for every finite number; each depends on its own entry of `at` alone.
        """

    def breaks(self) -> tuple[float, ...]:
        """Places or times where the value or its slope may jump. Integrals are split and load increments end there."""
        return ()

    def end(self) -> float:
        """Place or time from which on the value stays the same; infinite if it always changes."""
        return math.inf
