"""Scalars of steps: their paths in the recording, and writing them many steps at a time.

A line has the steps that it needs to pass through all others, as far as anyone sees, and where it would need most of
them the extremes alone. `results.vtkhdf` has every step.
"""

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

LINES = (*(style.colour for style in STYLES), "#F0E442", "#9AA0A6", "#F4A582", "#B2DF8A")
"""Colours of the lines of one plot, no two alike among the ten that a plot has at most."""
ROWS = 8192  # steps that are sent together: what a call costs is then shared by many
FEW = 200  # rows that are sent whatever they are
SEEN = 1e-3  # of the height of a plot: a pixel of a large one


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
        *(_series(layout, f"solver/{name}", (name,)) for name in ("sweeps", "iterations", "residual", "dt")),
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
        groups.append(_series(layout, f"nodes/{name}", (f"{name}.active", f"{name}.sticking")))
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
        self.rows, self.many = 0, False
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
        values, self.many, self.rows = self.waiting[: self.rows], self.many or self.rows == ROWS, 0
        np.fmax(self.largest, np.fmax.reduce(np.abs(values), axis=0), out=self.largest)
        for series in self.series if self.many else [series for series, _ in self.shown()]:
            kept = corners(values[:, 0], values[:, series.columns])
            columns = rr.Scalars.columns(scalars=values[kept][:, series.columns].ravel())
            if len(series.columns) > 1:
                columns = columns.partition(np.full(len(kept), len(series.columns)))
            when = frame_times(self.run, values[kept, 0], values[kept, 1])
            self.recording.send_columns(f"{self.appearance.path}/{series.path}", when, columns)

    def log_styles(self, several: bool) -> None:
        """Log names and colours of the lines, of several runs each run's colour; lines of zeros are hidden."""
        numbers: dict[str, int] = {}
        # if pixels are too few the viewer takes one of some rows, as if these were evenly apart
        policies = rr.components.AggregationPolicy
        policy = policies.MinMax if self.many else policies.Off
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
                aggregation_policy=policy,
            )
            self.recording.log(f"{self.appearance.path}/{series.path}", style, static=True)

    def shown(self) -> list[tuple[Series, list[bool]]]:
        """The series that are not zero all the time, and which of their lines are not."""
        shown = [(series, [bool(self.largest[column] > 0.0) for column in series.columns]) for series in self.series]
        return [(series, visible) for series, visible in shown if any(visible)]


def corners(x: Floats, lines: Floats) -> np.ndarray:
    """Rows to keep of lines (n, k) over x (n,), so that straight pieces between them pass through all others.

    Pieces are halved until they do, to `SEEN` of the largest value.
    """
    kept = np.zeros(len(x), np.bool_)
    kept[[0, -1]] = True
    allowed = SEEN * np.abs(lines[np.isfinite(lines)]).max(initial=0.0)
    pieces = np.array([[0, len(x) - 1]])
    while len(pieces := pieces[pieces[:, 1] > pieces[:, 0] + 1]):
        begin, end = pieces.T
        inner = end - begin - 1
        piece = np.repeat(np.arange(len(pieces)), inner)
        row = np.arange(len(piece)) - np.repeat(np.cumsum(inner) - inner, inner) + np.repeat(begin + 1, inner)
        share = ((x[row] - x[begin][piece]) / (x[end] - x[begin])[piece])[:, None]
        straight = lines[begin][piece] * (1.0 - share) + lines[end][piece] * share
        off = ~(np.abs(lines[row] - straight) <= allowed).all(axis=1)  # what is not a number is kept
        begin, end = pieces[np.bincount(piece[off], minlength=len(pieces)) > 0].T
        middle = (begin + end) // 2
        kept[middle] = True
        pieces = np.concatenate([np.stack([begin, middle], axis=1), np.stack([middle, end], axis=1)])
    most = max(FEW, len(x) // 2)
    return np.flatnonzero(kept if np.count_nonzero(kept) <= most else _extremes(lines))


def _extremes(lines: Floats) -> np.ndarray:
    """Mask of rows (n,) with the least or the largest of a line, in blocks so large that at most a fourth stays."""
    part = np.arange(len(lines)) // (8 * lines.shape[1])
    kept = np.zeros(len(lines), np.bool_)
    kept[[0, -1]] = True
    for line in lines.T:
        order = np.lexsort((line, part))
        first = np.searchsorted(part, np.arange(part[-1] + 1))
        kept[order[first]] = kept[order[[*(first[1:] - 1), -1]]] = True
    return kept
