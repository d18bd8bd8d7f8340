"""Every step's scalars: where each of them lives, and writing them many steps at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats
from contactlab.api.colours import STYLES, rgb
from contactlab.api.frame import Layout
from contactlab_rerun.gathered import Look

ROWS = 8192  # steps that are sent together: what a call costs is then shared by many
TIMELINES = ("step", "time")
"""Columns that are timelines and no series."""


@dataclass(frozen=True)
class Series:
    """One scalar: its column among `Layout.steps`, its group and the rest of its path below the run."""

    column: int
    group: str
    name: str

    @property
    def path(self) -> str:
        """Below the run."""
        return f"{self.group}/{self.name}"

    @property
    def counts(self) -> bool:
        """Whether these are whole numbers, of which no mean should be drawn where pixels are too few."""
        return self.name.endswith(("sweeps", "iterations", "active", "sticking"))


def all_series(layout: Layout) -> list[Series]:
    """Every column of `layout.steps` but the timelines."""
    return [_series(layout, k, name) for k, name in enumerate(layout.steps) if name not in TIMELINES]


def _series(layout: Layout, column: int, name: str) -> Series:
    owner, _, last = name.rpartition(".")
    if owner in layout.supports:
        return Series(column, "reaction", f"{owner}/{last}")
    if owner in {contact.name for contact in layout.contacts}:
        return Series(column, f"contact/{owner}", last)
    groups = {"energy": "energy", "cost": "time-per-step"}
    return Series(column, groups.get(owner, "solver"), last)


class SeriesWriter:
    """Collects blocks of steps and sends them in larger ones. `largest` are the magnitudes met so far by column."""

    def __init__(self, recording: rr.RecordingStream, layout: Layout, look: Look) -> None:
        self.recording, self.layout, self.look = recording, layout, look
        self.series = all_series(layout)
        self.waiting: list[Floats] = []
        self.rows = 0
        self.largest = np.zeros(len(layout.steps))

    def add(self, block: Floats) -> None:
        """Take a block (b, columns); it is copied."""
        self.waiting.append(block.copy())
        self.rows += len(block)
        if self.rows >= ROWS:
            self.flush()

    def flush(self) -> None:
        """Send what waits."""
        if not self.rows:
            return
        values = np.concatenate(self.waiting)
        self.waiting, self.rows = [], 0
        np.maximum(self.largest, np.abs(values).max(axis=0), out=self.largest)
        when = times(values[:, 0], values[:, 1])
        for series in self.series:
            columns = rr.Scalars.columns(scalars=np.ascontiguousarray(values[:, series.column]))
            self.recording.send_columns(f"{self.look.path}/{series.path}", when, columns)

    def log_styles(self, several: bool) -> None:
        """Name and colour of each line; among several runs those of its run."""
        numbers: dict[str, int] = {}
        for series in self.series:
            number = numbers[series.group] = numbers.get(series.group, -1) + 1
            colour = self.look.colour if several else STYLES[number % len(STYLES)].colour
            style = rr.SeriesLines(
                names=[self.look.title if several else series.name],
                colors=[rgb(colour)],
                widths=[1.5],
                aggregation_policy=rr.components.AggregationPolicy.Max if series.counts else None,
            )
            self.recording.log(f"{self.look.path}/{series.path}", style, static=True)

    def shown(self) -> list[Series]:
        """The series that are not zero all the time."""
        return [series for series in self.series if self.largest[series.column] > 0.0]


def times(steps: Sequence[float] | Floats, seconds: Sequence[float] | Floats) -> list[rr.TimeColumn]:
    """Both timelines: `step`, and `sim_time` to a nanosecond."""
    return [
        rr.TimeColumn("step", sequence=np.asarray(steps, np.int64)),
        rr.TimeColumn("sim_time", duration=np.asarray(seconds, np.float64)),
    ]
