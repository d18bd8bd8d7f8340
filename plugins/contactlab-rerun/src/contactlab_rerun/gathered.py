"""What a recording needs of one run, gathered while it goes on."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import ContactCurve, Event, Frame, Layout


@dataclass(frozen=True)
class Look:
    """How a run looks in a recording: `path` begins its entities, `title` tells it from others, `colour` is #rrggbb."""

    path: str
    title: str
    colour: str


@dataclass(frozen=True)
class Instant:
    """One frame in single precision, which is all that a viewer keeps.

    positions (N, 2), values (n,) of the shown field per cell of all bodies
    """

    step: int
    time: float
    positions: np.ndarray
    values: np.ndarray
    curves: Mapping[str, ContactCurve]
    scalars: Mapping[str, float]


@dataclass
class Gathered:
    """One run: its frames and events, and blocks of steps that wait to be written."""

    layout: Layout
    shown_field: str
    every: int
    instants: list[Instant] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    skipped: Instant | None = None

    def add(self, frame: Frame) -> None:
        """Keep a frame, or hold it back in case that it is the last one."""
        parts = [self._values(frame.cells[body.name]) for body in self.layout.bodies]
        instant = Instant(
            frame.step,
            frame.time,
            (self.layout.nodes + frame.displacement).astype(np.float32),
            np.concatenate(parts).astype(np.float32),
            frame.curves,
            frame.scalars,
        )
        if frame.number % self.every:
            self.skipped = instant
        else:
            self.instants.append(instant)
            self.skipped = None

    def finish(self) -> None:
        """The last frame is always shown."""
        if self.skipped is not None:
            self.instants.append(self.skipped)
            self.skipped = None

    def _values(self, cells: Mapping[str, Floats]) -> Floats:
        return cells.get(self.shown_field, np.zeros(len(cells["von_mises"])))

    @property
    def top(self) -> float:
        """Upper end of the colours: a corner singularity must not leave the rest in the dark."""
        rank = int(0.995 * (len(self.instants[0].values) - 1)) if self.instants else 0
        return max((float(np.partition(instant.values, rank)[rank]) for instant in self.instants), default=0.0)

    def largest(self, name: str) -> float:
        """Largest magnitude of a column of the contact curves."""
        columns = [getattr(curve, name) for curve in self._curves()]
        return max((float(np.abs(column).max(initial=0.0)) for column in columns), default=0.0)

    def _curves(self) -> Iterator[ContactCurve]:
        for instant in self.instants:
            yield from instant.curves.values()


def entity_name(text: str) -> str:
    """A text as one part of an entity path."""
    return re.sub(r"[^\w.=+-]+", "-", text).strip("-") or "run"


def nice(value: float) -> float:
    """The value rounded up to two figures."""
    if not value > 0.0:
        return 1.0
    unit = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(np.ceil(value / unit - 1e-9) * unit)


def short(value: Any) -> str:
    """A number for a label."""
    return f"{value:.4g}"


def tint(colour: str, shade: int) -> str:
    """The colour, paler for every further shade."""
    share = 1.0 - 0.62**shade
    parts = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(part + share * (255 - part)):02x}" for part in parts)
