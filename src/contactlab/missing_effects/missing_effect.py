"""What is told of an effect that is missing, and what a look for one must do."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, Protocol

import numpy as np

from contactlab.api import Floats


class Need(NamedTuple):
    """A missing effect.

    name  kebab-case, one per kind of effect
    key   of the scene, where the effect would be declared
    text  one sentence with the number that shows it
    add   the line to write in the scene
    """

    name: str
    key: str
    text: str
    add: str

    def __str__(self) -> str:
        return f"{self.text}; {self.add}"


class Look(Protocol):
    """Looks for one missing effect in one place.

    worst  (k,) numbers of the worst frame so far: all that a look remembers
    """

    worst: Floats

    def look(self) -> None:
        """Follow the model's present state in `worst`."""

    def need(self) -> Need | None:
        """What is missing by what was seen so far."""


class Known:
    """A need that the model shows when it is built."""

    def __init__(self, need: Need) -> None:
        self.found, self.worst = need, np.zeros(0)

    def look(self) -> None:
        """Nothing changes."""

    def need(self) -> Need:
        """The same all the time."""
        return self.found


Looks = Iterator[Look]


def per_cent(share: float) -> str:
    """0.0523 as "5.2 %"."""
    if share < 0.1:
        return f"{100.0 * share:.2g} %"
    return f"{100.0 * share:.0f} %" if share < 10.0 else f"{share:.0f} times"
