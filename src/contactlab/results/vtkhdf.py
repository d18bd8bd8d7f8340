"""The recorder `vtkhdf`: all of a run in one file that ParaView opens and that survives a kill.

Group `VTKHDF` is a transient unstructured grid, see `grid_file.py`. Group `contactlab` holds the same
run for this project: history, contact curves, every step's scalars, Newton iterations, events, provenance,
and what a restart needs. `load.py` reads it back.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import h5py
import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import ContactCurve, ContactLayout, Event, Frame, Iterate, IterationRow, Layout, StoredRun
from contactlab.api.recorder import Recorder, Recording
from contactlab.api.thinning import RECENT
from contactlab.results.checkpoint_slots import TEXT, Slots
from contactlab.results.checksums import GROUP as SUMS
from contactlab.results.checksums import of_rows, seal
from contactlab.results.contact_table import ROOM, ContactTable, is_recorded
from contactlab.results.event_table import EventTable
from contactlab.results.frame_sums import FrameSums
from contactlab.results.grid_file import GridFile, frame_bytes, write_grid
from contactlab.results.growing import Column, GrowingFile
from contactlab.results.iterate_table import IterateTable
from contactlab.results.iteration_table import GROUP, IterationTable
from contactlab.results.last_steps_file import excerpt, last_steps_folder
from contactlab.results.layout_file import FORMAT, write_layout
from contactlab.results.packed_file import pack
from contactlab.results.record_plan import MEGABYTE
from contactlab.results.result_file import FILE, RESUMABLE
from contactlab.results.step_columns import CHANGED
from contactlab.results.stored_text import read_columns, write_columns, write_text
from contactlab.results.thinned_table import ThinnedTable

KEPT = {"steps": "the scalars of steps", "contact": "the contact record"}
SHARE = 4.0  # of the budget of the contact record is for the scalars of steps: a million of the usual ones
SPARE_FRAMES = 4  # room in addition to the frames of the scene; runs that settle last a little longer
STEP_ROWS = 1024  # steps by which their room grows, at least, and of a chunk: HDF5 keeps some 400 B of each in memory
METADATA = 350_000.0  # bytes of a file besides its numbers, measured: some 60 datasets and the space reserved for them
FRAME_METADATA = 1200.0  # and of a frame: each dataset has an index of its chunks


@dataclass(frozen=True)
class VtkHdf(Recorder):
    """Writes `results.vtkhdf`. It has no fields: the scene's `record.frames` says how often."""

    by_default: ClassVar[bool] = True
    every_step: ClassVar[bool] = True
    every_contact: ClassVar[bool] = True
    every_iterate: ClassVar[bool] = True
    every_field: ClassVar[bool] = True
    stores_results: ClassVar[bool] = True

    def disk_bytes(self, layout: Layout, steps: float, memory: float) -> float:
        """Frames, steps, twice what a restart needs with a summary, and headers."""
        curves = 8.0 * sum(_columns(contact) * len(contact.slave_nodes) for contact in layout.contacts)
        frames = layout.frames * (frame_bytes(layout) + curves + FRAME_METADATA)
        beside = METADATA + (ROOM if layout.contacts else 0.0)
        kept = STEP_ROWS * -(-min(steps, most_steps(layout)) // STEP_ROWS)  # in whole chunks
        return beside + frames + 8.0 * kept * (len(layout.steps) + 1) + 2.0 * (memory + TEXT)

    def open(self, folder: Path, layout: Layout) -> Recording:
        """Create the file of a new run."""
        return VtkHdfRecording(GrowingFile(folder / FILE, new=True), layout)

    def resume(self, folder: Path, layout: Layout, run: StoredRun) -> Recording:
        """The file as it lies, cut back to what `run` holds."""
        recording = VtkHdfRecording(GrowingFile(folder / FILE, new=False), layout)
        last = run.summary.get("steps", 0)
        recording.cut(len(run.frames), last, len(run.events), len(run.iterations))
        recording.frame_steps = (0, run.frames[-1].step) if len(run.frames) else (0, 0)
        return recording


class VtkHdfRecording(Recording):
    """Recording to an open file. Steps and iterations become visible with the next frame, a frame immediately."""

    keeps_state: ClassVar[bool] = True

    def __init__(self, growing: GrowingFile, layout: Layout) -> None:
        self.growing, self.layout = growing, layout
        file = growing.file
        if "contactlab" not in file:
            file.create_group("contactlab").attrs["format"] = FORMAT
            write_grid(file.create_group("VTKHDF", track_order=True), layout)
            write_layout(file["contactlab"], layout)
            seal(file)
        self.own = file["contactlab"]
        self.grid = GridFile(growing, layout)
        self.curves = {contact.name: _curves(self.own, contact) for contact in layout.contacts}
        self.history: Column | None = None
        if "history" in self.own:
            write_columns(self.own, "history", read_columns(self.own, "history"))
            self.history = Column(self.own, "history", "f8", 1, self.own["history"].shape[1:])
        self.sums: FrameSums | None = None
        if self.history is not None:
            self.sums = self._frame_sums()
        self.steps_kept = _step_table(growing, self.own, layout)
        self.last_step = self.steps_kept.last_step
        write_columns(self.own, "curves", ContactCurve.COLUMNS)
        self.events = EventTable(growing, self.own)
        self.newton = IterationTable(growing, self.own) if GROUP in self.own else None
        self.iterated = IterateTable.there(growing, self.own)
        self.contact = ContactTable(growing, self.own, layout) if is_recorded(self.own, layout) else None
        self.slots = Slots.of(self.own)
        self.frame_steps = 0, 0

    def frame(self, frame: Frame) -> None:
        """Append a frame to the file."""
        row = self.grid.times.count
        if self.history is None or self.sums is None:
            self.history = Column(self.own, "history", "f8", 1, (len(frame.scalars),))
            write_columns(self.own, "history", list(frame.scalars))
            self.sums = self._frame_sums()
        if row >= self.grid.room:
            # room for more frames; the tables that say where each one begins are filled ahead
            more = max(8, row // 8) if row else self.layout.frames + SPARE_FRAMES
            self.growing.grow([*self.grid.columns, *self._own_columns()], more)
            self.grid.fill_offsets(row, row + more)
        self.grid.write(row, frame)
        for name, column in self.curves.items():
            curve = frame.curves[name]
            column.write(row, np.stack(list(curve.columns().values()), axis=1))
        self.history.write(row, [float(value) for value in frame.scalars.values()])
        self.sums.write(row, [column.sum for column in self._summed().values()])
        self._show_steps()
        self.grid.times.append(frame.time)
        self.frame_steps = self.frame_steps[1], frame.step

    def steps(self, block: Floats) -> None:
        """Append the scalars of several steps."""
        self.steps_kept.add([block, of_rows(block)], block[:, 0].astype(np.int64))
        self.last_step = int(block[-1, 0])

    def contact_steps(self, block: Mapping[str, np.ndarray]) -> None:
        """Append rows of the contact record."""
        if self.contact is None:
            self.contact = ContactTable(self.growing, self.own, self.layout)
        self.contact.add(block)

    def event(self, event: Event) -> None:
        """Append an event to the table of events."""
        self.events.add(event)

    def iterations(self, rows: Sequence[IterationRow]) -> None:
        """Append the rows of new Newton iterations."""
        if self.newton is None:
            self.newton = IterationTable(self.growing, self.own)
        self.newton.add(rows)

    def iterates(self, some: Sequence[Iterate]) -> None:
        """Append states after iterations."""
        if some and self.iterated is None:
            self.iterated = IterateTable(self.growing, self.own, len(self.layout.nodes), len(some[0].gap))
        if self.iterated is not None:
            self.iterated.add(some)

    def last_steps(self, end: str, frames: Sequence[Frame]) -> None:
        """Write the last steps into a file of their own, with the same fields."""
        with last_steps_folder(self.growing.path.parent, end) as folder:
            whole = VtkHdfRecording(GrowingFile(folder / FILE, new=True), replace(self.layout, frames=len(frames)))
            for frame in frames:
                whole.frame(frame)
            whole.close(excerpt(self.layout, end, frames))
            pack(folder / FILE)

    def news(self) -> Sequence[str]:
        """Messages on data left out since the frame before, because the budget is used up."""
        before, present = self.frame_steps
        return [
            f"record.budget is used up: of {KEPT[name]} {table.thinning}"
            for name, table in self._thinned().items()
            if before < table.sparser_at <= present
        ]

    def facts(self) -> Mapping[str, Any]:
        """Thinning of each table, for the summary."""
        thinned = {name: table.thinning.as_data() for name, table in self._thinned().items() if table.sparser_at}
        return {"thinned": thinned} if thinned else {}

    def _thinned(self) -> dict[str, ThinnedTable]:
        contact = {"contact": self.contact.kept} if self.contact is not None else {}
        return {"steps": self.steps_kept, **contact}

    def save(self, memory: Mapping[str, Floats], summary: Mapping[str, Any]) -> None:
        """Keep what a restart needs, and let readers see everything so far; a new file gets its name."""
        if self.slots is None:
            self.slots = Slots.create(self.own, memory)
        self._show_steps()
        self.slots.write(
            self.growing, memory, json.dumps(summary), self.grid.times.count, self.last_step, self.events.count
        )
        self.growing.publish()

    def close(self, summary: Mapping[str, Any]) -> None:
        """Give the spare room back and write the summary."""
        try:
            made = self.newton.count if self.newton is not None else 0
            self.cut(self.grid.times.count, self.last_step, self.events.count, made)
            if "summary" in self.own:
                del self.own["summary"]
            stored = write_text(self.own, "summary", json.dumps(summary))
            stored.attrs["serial"] = self.slots.serial if self.slots is not None else 0
            if self.grid.times.count:
                self.growing.publish()
        finally:
            self.growing.close()
        if summary["status"] not in RESUMABLE:
            pack(self.growing.path)

    def cut(self, frames: int, last_step: int, events: int, iterations: int) -> None:
        """Have exactly so much of everything, up to this step, and no spare room."""
        self.grid.cut(frames)
        for column in self._own_columns():
            column.resize(frames)
        self.steps_kept.cut(last_step)
        self.last_step = last_step
        self.events.cut(events)
        if self.newton is not None:
            self.newton.cut(iterations)
        if self.iterated is not None:
            self.iterated.cut(iterations)
        if self.contact is not None:
            self.contact.cut(last_step)
        self.growing.flush()

    def _show_steps(self) -> None:
        """Let readers see the steps and iterations so far."""
        self.steps_kept.show()
        if self.newton is not None:
            self.newton.show()
        if self.iterated is not None:
            self.iterated.show()
        if self.contact is not None:
            self.contact.show()

    def _own_columns(self) -> list[Column]:
        own = [*self.curves.values(), *([self.history] if self.history is not None else [])]
        return [*own, *([self.sums.column] if self.sums is not None else [])]

    def _summed(self) -> dict[str, Column]:
        """Everything that a frame fills, by the name in its checksums."""
        assert self.history is not None
        return (
            self.grid.fields | {f"curves of {name}": c for name, c in self.curves.items()} | {"history": self.history}
        )

    def _frame_sums(self) -> FrameSums:
        return FrameSums(self.own, list(self._summed()))


def _step_table(growing: GrowingFile, own: h5py.Group, layout: Layout) -> ThinnedTable:
    rows = Column(own, "steps", "f8", 1, (len(layout.steps),), STEP_ROWS)
    sums = Column(own.require_group(SUMS), "steps", "u8", 1, (), STEP_ROWS)
    write_columns(own, "steps", layout.steps)
    most = most_steps(layout)
    changed = [number for number, name in enumerate(layout.steps) if name.endswith(f".{CHANGED}")]

    def look(begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
        values = rows.rows(begin, end)
        return values[:, 0].astype(np.int64), np.any(values[:, changed] > 0.0, axis=1)

    return ThinnedTable(growing, rows.dataset, [rows, sums], look, most, STEP_ROWS)


def most_steps(layout: Layout) -> int:
    """Steps whose scalars are kept at most."""
    return max(4 * RECENT, int(SHARE * layout.budget * MEGABYTE / (8 * (len(layout.steps) + 1))))


def _columns(contact: ContactLayout) -> int:
    return len(ContactCurve.COLUMNS) + len(contact.memory)


def _curves(own: h5py.Group, contact: ContactLayout) -> Column:
    shape = (len(contact.slave_nodes), _columns(contact))
    return Column(own[f"contacts/{contact.name}"], "curves", "f8", 1, shape)
