"""What a study tells of its runs while they go on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol


class Named(Protocol):
    """Anything that is shown by its name."""

    @property
    def name(self) -> str:
        """Text shown beside the bar."""
        ...


class Bars(Protocol):
    """Receives the progress of a study's runs; may be called from any thread."""

    def say(self, text: str) -> None:
        """Show what goes on before the first run; an empty text takes it away."""

    def advance(self, name: str, fraction: float, step: int) -> None:
        """Show that a run has done this fraction of its way."""

    def finish(self, name: str, status: str) -> None:
        """Show that a run is over."""


MakeBars = Callable[[Sequence[Named]], AbstractContextManager[Bars]]
"""Called with the runs of a study; the bars are open while the runs go on."""


class Silence:
    """A progress display that shows nothing."""

    def say(self, text: str) -> None:
        """Show nothing."""

    def advance(self, name: str, fraction: float, step: int) -> None:
        """Show nothing."""

    def finish(self, name: str, status: str) -> None:
        """Show nothing."""


def no_bars(runs: Sequence[Named]) -> AbstractContextManager[Bars]:
    """Make bars that show nothing, for callers that want none."""
    return nullcontext(Silence())
