"""Progress of many runs at once: bars on a terminal, a line per finished run elsewhere."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from contactlab.studies.progress import Bars, Named, Silence


@contextmanager
def progress_bars(runs: Sequence[Named], show: bool | None = None) -> Iterator[Bars]:
    """Bars for the runs. `show`: None shows them where standard error is a terminal, False shows nothing."""
    console = Console(stderr=True)
    if show is False or (show is None and not sys.stderr.isatty()):
        yield Silence()
    elif not console.is_terminal:
        yield _Lines(console, len(runs))
    else:
        with _progress(console) as progress:
            yield _RichBars(progress, [run.name for run in runs])


def _progress(console: Console) -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=32),
        TextColumn("{task.percentage:>3.0f} %"),
        TextColumn("{task.fields[note]}"),
        TimeElapsedColumn(),
        console=console,
    )


class _Lines:
    def __init__(self, console: Console, total: int) -> None:
        self._console, self._total, self._done = console, total, 0
        self._said = ""

    def say(self, text: str) -> None:
        """What counts up is said once: "compiling kernel" and not each of its numbers."""
        head = re.split(r"\s+\d", text)[0]
        if head and head != self._said:
            self._said = head
            self._console.print(head)

    def advance(self, name: str, fraction: float, step: int) -> None:
        pass

    def finish(self, name: str, status: str) -> None:
        self._done += 1
        self._console.print(f"{self._done}/{self._total} {name}: {status}", highlight=False)


class _RichBars:
    """A bar per run, begun when the run begins, and one for all of them."""

    def __init__(self, progress: Progress, names: Sequence[str]) -> None:
        self._progress = progress
        self._tasks: dict[str, TaskID] = {
            name: progress.add_task(name, total=1.0, start=False, note="waiting") for name in names
        }
        self._all = progress.add_task("[bold]all runs", total=len(names), note="")

    def say(self, text: str) -> None:
        self._progress.update(self._all, note=text)

    def advance(self, name: str, fraction: float, step: int) -> None:
        self._progress.start_task(self._tasks[name])
        self._progress.update(self._tasks[name], completed=fraction, note=f"step {step}")

    def finish(self, name: str, status: str) -> None:
        colour = "green" if status == "finished" else "yellow" if status == "not-converged" else "red"
        task = self._tasks[name]
        self._progress.start_task(task)
        self._progress.update(task, completed=1.0, note=f"[{colour}]{status}")
        self._progress.stop_task(task)
        self._progress.advance(self._all)
