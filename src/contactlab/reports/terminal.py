"""Consoles that show what names and stored texts hold, and let none of it command the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.segment import Segment

from contactlab.errors import visible


class Terminal(Console):
    """A console of rich whose texts have no control characters; styles, and what rich itself sends, stay."""

    def say(self, text: str) -> None:
        """Print a line as it is: brackets are no markup, and long paths stay whole."""
        self.print(text, markup=False, highlight=False, soft_wrap=True)

    def render(self, renderable: Any, options: Any = None) -> Iterable[Segment]:
        """The segments of what is shown."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable() or segment.text == "\n":
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)
