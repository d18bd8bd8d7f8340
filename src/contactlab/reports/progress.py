"""The progress of many runs: bars of those under way on a terminal, a line per result elsewhere."""

from __future__ import annotations

import re
import sys
from threading import RLock

from rich import progress as rich_progress
from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn

from contactlab.jobs.progress import Progress
from contactlab.reports.terminal import Terminal

QUICK = ("preparing kernel", "loading kernel")
"""Actions too short for a line in a file or a pipe."""


def progress_of(total: int | None = None, show: bool | None = None) -> Progress:
    """Show the progress of so many results on standard error; None for an unknown number.

    show  None: on a terminal alone; False: nowhere
    """
    console = Terminal(stderr=True)
    if show is False or (show is None and not sys.stderr.isatty()):
        return Progress()
    return _Bars(console, total) if console.is_terminal else _Lines(console, total)


class _Lines(Progress):
    """A line for each result, and for what happens before the first run."""

    def __init__(self, console: Terminal, total: int | None) -> None:
        self._console, self._total, self._done = console, total, 0
        self._said = {"", *QUICK}

    def say(self, text: str) -> None:
        """Print what counts up once: "compiling kernel" without its numbers; not what takes no time."""
        head = re.split(r"\s+\d", text)[0]
        if head not in self._said:
            self._said.add(head)
            self._print(head)

    def told(self, text: str) -> None:
        """Print a result with its number."""
        self._done += 1
        counted = "" if self._total is None else f"{self._done}/{self._total} "
        self._print(f"{counted}{text}")

    def _print(self, text: str) -> None:
        self._console.say(text)


class _Bars(_Lines):
    """A bar for each run under way, and one for all results."""

    def __init__(self, console: Terminal, total: int | None) -> None:
        super().__init__(console, total)
        self._lock = RLock()
        self._bars = rich_progress.Progress(
            TextColumn("{task.description}"), BarColumn(bar_width=32), TextColumn("{task.percentage:>3.0f} %"),
            TextColumn("{task.fields[note]}"), TimeElapsedColumn(), console=console, transient=True,
        )  # fmt: skip
        self._runs: dict[str, TaskID] = {}
        self._all = self._bars.add_task("[bold]all", total=total, note="")
        self._bars.start()

    def say(self, text: str) -> None:
        """Write next to the overall progress bar."""
        self._bars.update(self._all, note=text)

    def begun(self, name: str) -> None:
        """Add a bar."""
        with self._lock:
            self._runs[name] = self._bars.add_task(name, total=1.0, note="")

    def advance(self, name: str, fraction: float, step: int) -> None:
        """Lengthen the bar of a run."""
        with self._lock:
            if name in self._runs:
                self._bars.update(self._runs[name], completed=fraction, note=f"step {step}")

    def ended(self, name: str) -> None:
        """Take a bar away."""
        with self._lock:
            if name in self._runs:
                self._bars.remove_task(self._runs.pop(name))

    def told(self, text: str) -> None:
        """Print a result above the bars."""
        super().told(text)
        self._bars.update(self._all, completed=self._done, total=self._total)

    def close(self) -> None:
        """Take all bars away."""
        self._bars.stop()
