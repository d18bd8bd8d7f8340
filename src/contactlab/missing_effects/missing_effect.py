"""How a missing effect is told, and what a detector of one must do."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from contactlab.api import Floats, RunWarning


def needed(code: str, value: float, limit: float, key: str, seen: str, add: str) -> RunWarning:
    """A missing effect: what was `seen`, one sentence with its number, and the line to `add` to the scene at `key`."""
    return RunWarning(code, value, limit, key, f"{seen}; {add}")


class Detector(Protocol):
    """Detects one missing effect in one place.

    worst  (k,) numbers of the worst frame so far: all that a detector remembers
    """

    worst: Floats

    def update(self) -> None:
        """Take the model's present state into `worst`."""

    def warning(self) -> RunWarning | None:
        """The warning of what is missing by what was seen so far, None where nothing is."""


class Known:
    """Something missing that the model shows when it is built."""

    def __init__(self, warning: RunWarning) -> None:
        self.found, self.worst = warning, np.zeros(0)

    def update(self) -> None:
        """Do nothing: what is missing does not depend on the state."""

    def warning(self) -> RunWarning:
        """The warning that was found when the run began."""
        return self.found


Detectors = Iterator[Detector]


def per_cent(share: float) -> str:
    """Write a share as a percentage: 0.0523 as "5.2 %"."""
    if share < 0.1:
        return f"{100.0 * share:.2g} %"
    return f"{100.0 * share:.0f} %" if share < 10.0 else f"{share:.0f} times"
