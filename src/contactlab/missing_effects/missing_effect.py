"""How a missing effect is told, and what a look for one must do."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from contactlab.api import Floats, RunWarning


def needed(code: str, value: float, limit: float, key: str, seen: str, add: str) -> RunWarning:
    """A missing effect: what was `seen`, one sentence with its number, and the line to `add` to the scene at `key`."""
    return RunWarning(code, value, limit, key, f"{seen}; {add}")


class Look(Protocol):
    """Looks for one missing effect in one place.

    worst  (k,) numbers of the worst frame so far: all that a look remembers
    """

    worst: Floats

    def look(self) -> None:
        """Follow the model's present state in `worst`."""

    def warning(self) -> RunWarning | None:
        """What is missing by what was seen so far."""


class Known:
    """Something missing that the model shows when it is built."""

    def __init__(self, warning: RunWarning) -> None:
        self.found, self.worst = warning, np.zeros(0)

    def look(self) -> None:
        """Do nothing: what is missing does not depend on the state."""

    def warning(self) -> RunWarning:
        """The warning that was found when the run began."""
        return self.found


Looks = Iterator[Look]


def per_cent(share: float) -> str:
    """0.0523 as "5.2 %"."""
    if share < 0.1:
        return f"{100.0 * share:.2g} %"
    return f"{100.0 * share:.0f} %" if share < 10.0 else f"{share:.0f} times"
