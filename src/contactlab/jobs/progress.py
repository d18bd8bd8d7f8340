"""Progress of plans: what the driver and views report while runs are made."""

from __future__ import annotations


class Progress:
    """Progress that shows nothing; subclasses override. `begun`, `advance` and `say` are called from any thread."""

    def say(self, text: str) -> None:
        """Show what happens before the first step, such as compilation; an empty string removes it."""

    def begun(self, name: str) -> None:
        """Show that a run has begun."""

    def advance(self, name: str, fraction: float, step: int) -> None:
        """Show that a run has done this fraction of its loading."""

    def ended(self, name: str) -> None:
        """Show that a run has ended."""

    def told(self, text: str) -> None:
        """Show one more result: a row, a cell, a point."""

    def close(self) -> None:
        """Show nothing any more."""
