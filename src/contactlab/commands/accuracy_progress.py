"""What a study of cases shows while it runs: a line per point, and table, files and page rewritten as points come."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from time import monotonic

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from contactlab.accuracy.evaluation import Evaluation, evaluate
from contactlab.accuracy.files import write
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy

LEAST = 3.0
"""Wall time [s] from one writing of the page to the next, at least."""
SHARE = 0.05
"""Largest share of the time that is spent on writing it."""


def import_what_draws() -> None:
    """Libraries that draw the page: seconds where Python has not compiled them yet, for which no point should wait."""
    import_module("contactlab.reports.accuracy_page")


def write_all(evaluated: Evaluation, folder: Path, figures: bool = True) -> None:
    """Tables as CSV and JSON, the page, and its `figures` as files of their own."""
    from contactlab.reports.accuracy_page import write_accuracy_page

    write(evaluated, folder)
    write_accuracy_page(evaluated, folder, files=figures)


class Progress:
    """Hears of every point; with a terminal on standard error the table of costs is drawn there, too."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.live = Live(console=Console(stderr=True), auto_refresh=False, transient=True) if _watched() else None
        self.table: Group | Text = Text("")
        self.page = Text("")
        self.line = ""
        self.next = 0.0

    def __enter__(self) -> Progress:
        """Begin to draw."""
        if self.live is not None:
            self.live.start()
        return self

    def __exit__(self, *raised: object) -> None:
        """Leave nothing behind on the terminal."""
        if self.live is not None:
            self.live.stop()

    def told(self, point: Point, done: int, total: int) -> None:
        """A point is done."""
        self.line = f"{done}/{total} {point.case}, {point.contender}, {point.slave}, level {point.level}: {_end(point)}"
        if self.live is None:
            print(self.line, file=sys.stderr, flush=True)
        else:
            self.live.update(
                Group(self.table, self.page, Text(self.line, no_wrap=True, overflow="ellipsis")), refresh=True
            )

    def so_far(self, found: Callable[[], Accuracy]) -> None:
        """Write what there is, unless it was written shortly before."""
        began = monotonic()
        if began < self.next:
            return
        evaluated = evaluate(found())
        write_all(evaluated, self.folder, figures=False)
        where = f"page so far, rewritten as points come: {self.folder / 'accuracy.html'}"
        if self.live is not None:
            from contactlab.reports.accuracy_table import costs_table

            self.table, self.page = costs_table(evaluated.found, evaluated.costs), Text(where)
        elif not self.next:
            print(where, file=sys.stderr, flush=True)
        now = monotonic()
        self.next = now + max(LEAST, (now - began) / SHARE)


def _watched() -> bool:
    return sys.stderr.isatty()


def _end(point: Point) -> str:
    if point.finished:
        return f"{100.0 * point.error:.3g} % in {point.cost:.3g} s"
    return f"{point.status}: {point.reason.splitlines()[0] if point.reason else ''}"
