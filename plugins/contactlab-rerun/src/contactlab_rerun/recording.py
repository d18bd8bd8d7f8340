"""Recordings of runs in a file: one run while it is made, or several finished runs."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import STYLES, styles
from contactlab.api.frame import Event, Frame, Iterate, IterationRow, Layout, StoredRun
from contactlab.api.recorder import Recording, replay
from contactlab_rerun.gathered import Appearance, Gathered, entity_name, tint
from contactlab_rerun.recorder import Rerun

if TYPE_CHECKING:
    from contactlab_rerun.series import SeriesWriter
    from contactlab_rerun.timeline_file import TimelineFile

LOG = "RUST_LOG"
MANY = 4096  # steps that wait before the library is needed
Summary = Mapping[str, Any]


@contextmanager
def imported_quietly() -> Iterator[None]:
    """Import the library in here: a third faster without garbage collection, and without its word on missing indices.

    What it may say is decided while it is imported. Who has set its variable decides themselves.
    """
    collecting, said = gc.isenabled(), os.environ.get(LOG)
    gc.disable()
    os.environ.setdefault(LOG, "warn,re_log_encoding=error")
    try:
        yield
    finally:
        if said is None:
            del os.environ[LOG]
        if collecting:
            gc.enable()


class RunRecording(Recording):
    """Recording of a run. Steps wait in memory until there are many; frames until the end, when scales are known."""

    def __init__(
        self,
        open_run: Callable[[Gathered], SeriesWriter],
        options: Rerun,
        layout: Layout,
        finish: Callable[[Summary], None],
    ) -> None:
        self.run, self.open_run, self.finish = Gathered(layout, options.field, options.frames_apart), open_run, finish
        self.series: SeriesWriter | None = None
        self.waiting: list[Floats] = []

    def _series(self) -> SeriesWriter:
        """Return the writer of steps; the first call imports the library and begins the file."""
        if self.series is None:
            self.series = self.open_run(self.run)
            for block in self.waiting:
                self.series.add(block)
            self.waiting.clear()
        return self.series

    def frame(self, frame: Frame) -> None:
        """Keep what is shown of a frame."""
        self.run.add(frame)

    def steps(self, block: Floats) -> None:
        """Send scalars of steps on, many at a time."""
        if self.series is None and sum(map(len, self.waiting)) < MANY:
            self.waiting.append(block.copy())
        else:
            self._series().add(block)

    def contact_steps(self, block: Mapping[str, np.ndarray]) -> None:
        """Keep rows of the contact record for the end of the file."""
        for name, rows in block.items():
            self.run.recorded.setdefault(name, []).append(rows)

    def last_steps(self, end: str, frames: Sequence[Frame]) -> None:
        """Keep what is shown of the last steps."""
        self.run.add_last_steps(end, frames)

    def event(self, event: Event) -> None:
        """Keep an event for the end of the file."""
        self.run.events.append(event)

    def iterations(self, rows: Sequence[IterationRow]) -> None:
        """Keep Newton iterations for the end of the file."""
        self.run.iterations.extend(rows)

    def iterates(self, some: Sequence[Iterate]) -> None:
        """Keep states after iterations for the end of the file."""
        self.run.iterates.extend(some)

    def close(self, summary: Summary) -> None:
        """Draw all frames and give the file its name, if this run is the whole of it."""
        self._series()
        self.series = None  # the file lets go of what it wrote to
        self.finish(summary)


def record_run(options: Rerun, folder: Path, layout: Layout) -> RunRecording:
    """Return the recording of a run in progress, in a file of its own."""
    algorithms = ", ".join(dict.fromkeys(contact.algorithm for contact in layout.contacts))
    title = f"{layout.title}: {algorithms}" if algorithms else layout.title
    appearance = Appearance(f"/{entity_name(folder.resolve().name)}", title, STYLES[0].colour)
    if find_spec("rerun") is None:  # raised before the run, though the library is not needed yet
        raise ModuleNotFoundError("No module named 'rerun'")
    files: list[TimelineFile] = []

    def open_run(run: Gathered) -> SeriesWriter:
        files.append(_begun(folder / options.shown_file, options, "step"))
        return files[0].open_run(run, appearance)

    return RunRecording(open_run, options, layout, lambda summary: files[0].finish([summary]))


def _begun(path: Path, options: Rerun, timeline: str) -> TimelineFile:
    with imported_quietly():
        from contactlab_rerun.timeline_file import TimelineFile

    return TimelineFile(path, options, timeline)


def write_comparison(options: Rerun, path: Path, runs: Mapping[str, StoredRun]) -> None:
    """Write one file with all runs that stored a frame, on one cursor."""
    shown = {title: run for title, run in runs.items() if len(run.frames)}
    if not shown:
        return
    file = _begun(path, options, "sim_time")
    for title, appearance in appearances(shown).items():
        run = shown[title]
        one = RunRecording(partial(file.open_run, appearance=appearance), options, run.layout, lambda summary: None)
        replay(run, one, steps=True, contact=True, fields=True, iterates=True)
        one.close(run.summary)
    file.finish([run.summary for run in shown.values()])


def appearances(runs: Mapping[str, StoredRun]) -> dict[str, Appearance]:
    """Colours by algorithm as in the report; runs that share an algorithm have paler and paler shades of it."""
    names = {title: run.layout.contacts[0].algorithm if run.layout.contacts else title for title, run in runs.items()}
    chosen = styles(names.values())
    seen: dict[str, int] = {}
    found = {}
    for title, name in names.items():
        shade = seen.get(name, 0)
        seen[name] = shade + 1
        found[title] = Appearance(f"/{entity_name(title)}", title, tint(chosen[name].colour, shade))
    return found
