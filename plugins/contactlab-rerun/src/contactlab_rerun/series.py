"""Every step's scalars: where each of them lives, and writing them many steps at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import STYLES, rgb
from contactlab.api.frame import Layout
from contactlab_rerun.gathered import Appearance, Gathered
from contactlab_rerun.timelines import frame_times

COUNTS = ("solver", "nodes")
COUNTED = ("active", "sticking", "changed")  # the last one is not there in older runs
LINES = (*(style.colour for style in STYLES), "#F0E442", "#9AA0A6", "#F4A582", "#B2DF8A")
"""Colours of the lines of one plot, no two alike among the ten that a plot has at most."""
ROWS = 8192  # steps that are sent together: what a call costs is then shared by many


@dataclass(frozen=True)
class Series:
    """Scalars that share an entity: together they cost little more than one of them alone.

    path     below the run; its first word is the group that plots choose by
    columns  among `Layout.steps`
    names    of the lines
    """

    path: str
    columns: tuple[int, ...]
    names: tuple[str, ...]

    @property
    def group(self) -> str:
        """The first word of the path, by which curves share a plot."""
        return self.path.partition("/")[0]


def all_series(layout: Layout) -> list[Series]:
    """All columns of `layout.steps` but the timelines, each in one series."""
    of_contact = tuple(name for name in layout.steps if name.startswith("energy.contact."))
    energy = tuple(name for name in layout.steps if name.startswith("energy.") and name not in of_contact)
    groups = [
        _series(layout, "solver", ("sweeps", "iterations", "residual", "dt")),
        _series(layout, "energy", energy),
        _series(layout, "time-per-step", ("cost.elements", "cost.contact")),
    ]
    if of_contact:
        groups.append(_series(layout, "contact-work", of_contact))
    if layout.supports:
        names = tuple(f"{on}.{component}" for on in layout.supports for component in ("fx", "fy"))
        groups.append(Series("reaction", _columns(layout, names), names))
    for contact in layout.contacts:
        name = contact.name
        counted = [column for what in COUNTED if (column := f"{name}.{what}") in layout.steps]
        groups.append(_series(layout, f"nodes/{name}", counted))
        groups.append(_series(layout, f"violation/{name}", (f"{name}.penetration",)))
    return groups


def _columns(layout: Layout, names: Sequence[str]) -> tuple[int, ...]:
    return tuple(layout.steps.index(name) for name in names)


def _series(layout: Layout, path: str, names: Sequence[str]) -> Series:
    return Series(path, _columns(layout, names), tuple(name.rpartition(".")[2] for name in names))


class SeriesWriter:
    """Collects blocks of steps and sends them in larger ones."""

    def __init__(self, recording: rr.RecordingStream, run: Gathered, appearance: Appearance) -> None:
        self.recording, self.run, self.appearance, layout = recording, run, appearance, run.layout
        self.series = all_series(layout)
        self.waiting = np.empty((ROWS, len(layout.steps)))
        self.rows = 0
        self.largest = np.zeros(len(layout.steps))

    def add(self, block: Floats) -> None:
        """Take a block (b, columns) of any length; it is copied."""
        while len(block):
            some = block[: ROWS - self.rows]
            self.waiting[self.rows : self.rows + len(some)] = some
            self.rows += len(some)
            block = block[len(some) :]
            if self.rows == ROWS:
                self.flush()

    def flush(self) -> None:
        """Send the rows that wait to the file."""
        if not self.rows:
            return
        values, self.rows = self.waiting[: self.rows], 0
        np.fmax(self.largest, np.fmax.reduce(np.abs(values), axis=0), out=self.largest)
        when = frame_times(self.run, values[:, 0], values[:, 1])
        for series in self.series:
            columns = rr.Scalars.columns(scalars=values[:, series.columns].ravel())
            if len(series.columns) > 1:
                columns = columns.partition(np.full(len(values), len(series.columns)))
            self.recording.send_columns(f"{self.appearance.path}/{series.path}", when, columns)

    def log_styles(self, several: bool) -> None:
        """Names and colours of the lines, among several runs those of their run; what is always zero is hidden."""
        numbers: dict[str, int] = {}
        for series, visible in self.shown():
            names, colours = [], []
            for name in series.names:
                number = numbers[series.group] = numbers.get(series.group, -1) + 1
                names.append(self.appearance.title if several else name)
                colours.append(rgb(self.appearance.colour if several else LINES[number % len(LINES)]))
            style = rr.SeriesLines(
                names=names,
                colors=colours,
                widths=[1.5] * len(names),
                visible_series=visible,
                # of whole numbers no mean should be drawn where pixels are too few
                aggregation_policy=rr.components.AggregationPolicy.Max if series.group in COUNTS else None,
            )
            self.recording.log(f"{self.appearance.path}/{series.path}", style, static=True)

    def shown(self) -> list[tuple[Series, list[bool]]]:
        """The series, and which of their lines are not zero all the time."""
        return [(series, [bool(self.largest[column] > 0.0) for column in series.columns]) for series in self.series]
