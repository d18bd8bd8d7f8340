"""Data of one run for a recording, gathered while it runs."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contactlab.api.arrays import XX, YY, ZZ, Floats, Ints
from contactlab.api.frame import SLIP, STATES, ContactCurve, Event, Frame, Iterate, IterationRow, Layout
from contactlab.api.recorder import FAILURE, WARNING

VON_MISES, PRESSURE, NO_FIELD = "von_mises", "pressure", "none"
SHORT = {"plastic_strain": "equivalent_plastic_strain"}
"""Alternative names of fields."""


def check_field(name: str, layout: Layout) -> None:
    """Raise ValueError if no body has such a field."""
    known = [VON_MISES, PRESSURE, *(v for body in layout.bodies for v in body.shown_variables), NO_FIELD]
    if SHORT.get(name, name) not in known:
        raise ValueError(f"field: got {name}, allowed in this scene: {', '.join(dict.fromkeys(known))}")


@dataclass(frozen=True)
class Appearance:
    """Appearance of a run in a recording: `path` begins its entities, `title` identifies it, `colour` is #rrggbb."""

    path: str
    title: str
    colour: str


@dataclass(frozen=True)
class Instant:
    """A frame in single precision, which is all that a viewer keeps.

    positions (N, 2), values (n,) of the shown field per cell of all bodies
    """

    step: int
    time: float
    positions: np.ndarray
    values: np.ndarray
    curves: Mapping[str, ContactCurve]
    scalars: Mapping[str, float]


@dataclass(frozen=True)
class Surface:
    """The slave surface of one contact at all F frames: s and chain (m,), all else (F, m), see `ContactCurve`."""

    s: Floats
    chain: Ints
    x: Floats
    y: Floats
    pressure: Floats
    shear: Floats
    gap: Floats
    state: Ints

    @property
    def along(self) -> Ints:
        """The nodes from the beginning of the first chain to the end of the last (m,)."""
        return np.lexsort((self.s, self.chain)).astype(np.int32)

    @property
    def points(self) -> Floats:
        """Deformed positions (F, m, 2)."""
        return np.stack([self.x, self.y], axis=-1)


@dataclass
class Gathered:
    """Frames, events and Newton iterations of a run, and states after iterations. Call `finish` before any query.

    last_steps         frames of every step before a failure or a warning; `instants` has them, too, once it is finished
    recorded, records  rows of the contact record by contact, in blocks and, once it is finished, in one
    """

    layout: Layout
    shown_field: str
    every: int
    instants: list[Instant] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    iterations: list[IterationRow] = field(default_factory=list)
    iterates: list[Iterate] = field(default_factory=list)
    skipped: Instant | None = None
    last_steps: dict[str, list[Instant]] = field(default_factory=dict)
    surfaces: dict[str, Surface] = field(default_factory=dict)
    recorded: dict[str, list[np.ndarray]] = field(default_factory=dict)
    records: dict[str, np.ndarray] = field(default_factory=dict)

    def add(self, frame: Frame) -> None:
        """Keep a frame, or hold it back in case that it is the last one."""
        instant = self._instant(frame)
        if frame.number % self.every:
            self.skipped = instant
        else:
            self.instants.append(instant)
            self.skipped = None

    def add_last_steps(self, end: str, frames: Sequence[Frame]) -> None:
        """Keep frames of every one of the last steps before `end`."""
        self.last_steps[end] = [self._instant(frame) for frame in frames]

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Finish the run: its last frame is always shown, and an early end is an event."""
        if self.skipped is not None:
            self.instants.append(self.skipped)
            self.skipped = None
        known = {instant.step for instant in self.instants}
        more = {instant.step: instant for part in self.last_steps.values() for instant in part}
        self.instants += [instant for step, instant in more.items() if step not in known]
        self.instants.sort(key=lambda instant: instant.step)
        self.surfaces = {contact.name: self._surface(contact.name) for contact in self.layout.contacts}
        self.records = {name: np.concatenate(blocks) for name, blocks in self.recorded.items()}
        self.recorded.clear()
        if summary.get("status", "finished") != "finished" and self.instants:
            last = self.instants[-1]
            text = f"{summary['status']}: {summary.get('reason', '')}"
            self.events.append(Event(max(int(summary.get("steps", 0)), last.step), last.time, "error", text))

    def window(self) -> tuple[int, int] | None:
        """First and last of the steps to look at first: the steps before a failure, or before the first warning."""
        for end in (FAILURE, WARNING):
            if steps := self.last_steps.get(end):
                return steps[0].step, steps[-1].step
        return None

    def records_of(self, contact: str) -> list[str]:
        """Tractions that the record of a contact has."""
        rows = self.records.get(contact)
        return [] if rows is None else [name for name in ("pressure", "shear") if name in (rows.dtype.names or ())]

    def recorded_frames(self, contact: str) -> dict[int, np.void]:
        """Rows of the record of a contact by the frames whose steps are in it."""
        rows = self.records.get(contact)
        if rows is None or not len(rows):
            return {}
        steps = np.array([instant.step for instant in self.instants])
        places = np.minimum(np.searchsorted(rows["step"], steps), len(rows) - 1)
        there = np.flatnonzero(rows["step"][places] == steps)
        return {int(frame): rows[places[frame]] for frame in there}

    def _surface(self, name: str) -> Surface:
        curves = [instant.curves[name] for instant in self.instants]
        columns = ("x", "y", "pressure", "shear", "gap", "state")
        found = {column: np.array([getattr(curve, column) for curve in curves]) for column in columns}
        # multipliers of open nodes balance their neighbours and are not tractions
        closed = found["state"] > 0
        found["pressure"] = np.where(closed, found["pressure"], [curve.nodal_pressure for curve in curves])
        found["shear"] = np.where(closed, found["shear"], 0.0)
        return Surface(curves[0].s, curves[0].chain, **found)

    def _instant(self, frame: Frame) -> Instant:
        parts = [self._values(frame.cells[body.name]) for body in self.layout.bodies]
        return Instant(
            frame.step,
            frame.time,
            (self.layout.nodes + frame.displacement).astype(np.float32),
            np.concatenate(parts).astype(np.float32),
            frame.curves,
            frame.scalars,
        )

    def _values(self, cells: Mapping[str, Floats]) -> Floats:
        if self.shown_field == PRESSURE:
            return np.asarray(-cells["stress"][:, [XX, YY, ZZ]].mean(axis=1))
        return cells.get(SHORT.get(self.shown_field, self.shown_field), np.zeros(len(cells["von_mises"])))

    @property
    def extent(self) -> tuple[float, float]:
        """Both ends of the colours, zero among them: a corner singularity must not leave the rest in the dark."""
        rank = int(0.995 * (len(self.instants[0].values) - 1))
        ends = [np.partition(i.values, [len(i.values) - 1 - rank, rank]) for i in self.instants]
        low = min(float(values[len(values) - 1 - rank]) for values in ends)
        return min(0.0, low), max(0.0, *(float(values[rank]) for values in ends))

    @property
    def largest_pressure(self) -> float:
        """Largest magnitude of the pressure on any contact."""
        return max(
            (float(np.abs(surface.pressure).max(initial=0.0)) for surface in self.surfaces.values()), default=0.0
        )

    @property
    def frictional(self) -> bool:
        """Return whether any contact has friction."""
        return any(contact.friction for contact in self.layout.contacts)


def state_names(frictional: bool) -> tuple[str, ...]:
    """Names of the states of a contact node: without friction there is no slip, only closed."""
    return STATES if frictional else (*STATES[:SLIP], "closed")


def entity_name(text: str) -> str:
    """Make a string usable as one part of an entity path."""
    return re.sub(r"[^\w.=+-]+", "-", text).strip("-") or "run"


def nice(value: float) -> float:
    """Round a value up to two figures."""
    if not value > 0.0:
        return 1.0
    unit = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(np.ceil(value / unit - 1e-9) * unit)


def short(value: Any) -> str:
    """Write a number for a label, with few digits."""
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e6 else f"{value:.4g}"


def tint(colour: str, shade: int) -> str:
    """Make the colour paler for every further shade."""
    share = 1.0 - 0.62**shade
    parts = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(part + share * (255 - part)):02x}" for part in parts)
