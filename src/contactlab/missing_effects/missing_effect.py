"""Warning about a missing effect, and the interface of its detectors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

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
        """Warning about the missing effect by what was seen so far, None if there is none."""


Detectors = Iterator[Detector]


def per_cent(share: float) -> str:
    """Write a share as a percentage: 0.0523 as "5.2 %"."""
    if share < 0.1:
        return f"{100.0 * share:.2g} %"
    return f"{100.0 * share:.0f} %" if share < 10.0 else f"{share:.0f} times"
