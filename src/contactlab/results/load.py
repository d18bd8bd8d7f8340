"""Results read back from `results.vtkhdf`, by h5py and NumPy alone."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, overload

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import BodyLayout, ContactCurve, Frame, Layout
from contactlab.errors import RequestError, one_line
from contactlab.results.checkpoint_slots import Checkpoint, Slots
from contactlab.results.checksums import Damage, StoredSums, sealed
from contactlab.results.damage import BROKEN, TABLES, check_all, damage_told, whole_frames, whole_steps
from contactlab.results.event_table import read_events
from contactlab.results.iteration_table import read_iterations
from contactlab.results.layout_file import FORMAT, read_layout
from contactlab.results.results import ContactHistory, Results

FILE = "results.vtkhdf"
T = TypeVar("T")
STEPS_AT_ONCE = 65536


def load_results(folder: str | Path, salvage: bool = False) -> Results:
    """The results of the run in `folder`, equal to what `simulate` gave back; as far as it went if it was killed.

    With `salvage` a damaged file gives all that is whole: frames, rows of tables and steps that are not are left out,
    and `Results.lost` names what is missing. Raises RequestError where there is no readable `results.vtkhdf`, and,
    without `salvage`, where something in it is not as it was written; frames and steps are checked when they are read.
    """
    folder = Path(folder)
    with opened(folder) as file:
        if salvage:
            try:
                return _Reader(file, folder, salvage).results()
            except BROKEN as problem:
                raise RequestError(
                    f"nothing in the file can be read: {one_line(problem)}", where=str(folder / FILE), hint=TABLES
                ) from problem
        with damage_told(folder):
            return _Reader(file, folder).results()


def load_checkpoint(folder: Path) -> tuple[Results, Checkpoint] | None:
    """The newest checkpoint in `folder` and the run up to it; None if nothing was saved before the run stopped.

    Raises RequestError where anything up to there is damaged.
    """
    with opened(folder) as file, damage_told(folder):
        reader = _Reader(file, folder)
        if reader.checkpoint is None:
            return None
        reader.limit(reader.checkpoint)
        check_all(file, reader.layout, reader.frames, reader.steps)
        return reader.results(), reader.checkpoint


def opened(folder: Path) -> Any:
    """The file in `folder`, open for reading. Raises RequestError where that is not possible."""
    import h5py

    path = folder / FILE
    if not path.is_file():
        found = "the folder has no results.vtkhdf" if folder.is_dir() else "there is no such folder"
        raise RequestError(
            found, where=str(folder), allowed="the folder of a run whose record.recorders include vtkhdf (the default)"
        )
    try:
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        raise RequestError(f"the file cannot be read: {error}", where=str(path), hint=TABLES) from error
    try:
        ours = "contactlab" in file and "VTKHDF" in file
        version = file["contactlab"].attrs.get("format") if ours else None
    except BROKEN:
        ours = False
    if not ours:
        file.close()
        raise RequestError(
            "the file was not written by contactlab, or its headers are damaged", where=str(path), hint=TABLES
        )
    if version != FORMAT:
        file.close()
        raise RequestError(
            "the file was written by another version of contactlab",
            where=str(path),
            got=f"format {version}",
            allowed=f"format {FORMAT}",
            hint="read it with the version in its summary.json, or make the run again from its scene.toml",
        )
    return file


class _Reader:
    """One open file. With `salvage` what is damaged is left out, and `lost` tells of it."""

    def __init__(self, file: Any, folder: Path, salvage: bool = False) -> None:
        self.file, self.folder, self.own = file, folder, file["contactlab"]
        self.salvage = salvage
        self.lost: list[str] = []
        self.layout = read_layout(self.own)
        self.frames = self._or("the frames", lambda: _frame_count(file, salvage), 0)
        self.steps = self._or("the steps", lambda: int(self.own["steps"].attrs["count"]), 0)
        self.events = self._or("the events", lambda: len(self.own["events/step"]), 0)
        self.last_step = math.inf
        slots = self._or("the saved state", lambda: Slots.of(self.own), None)
        self.checkpoint = self._or("the saved state", lambda: self._newest(slots), None)
        saved = slots.serial if slots is not None else 0
        # the summary of a run that was taken up again is that of an earlier end
        self.closed = "summary" in self.own and int(self.own["summary"].attrs.get("serial", saved)) >= saved
        self.sums = self._or("the frames", lambda: StoredSums(self.own), None) if self.frames else None
        self.numbers = self._numbers()

    def _newest(self, slots: Slots | None) -> Checkpoint | None:
        return slots.newest(self.frames, self.steps, self.events, self.salvage) if slots is not None else None

    def _or(self, what: str, read: Callable[[], T], otherwise: T) -> T:
        """What `read` gives; `otherwise`, where that fails and only what is whole is wanted."""
        if not self.salvage:
            return read()
        try:
            return read()
        except BROKEN:
            self.lost.append(what)
            return otherwise

    def _numbers(self) -> list[int]:
        """Numbers of the frames that are read."""
        if not self.salvage:
            return list(range(self.frames))
        found = whole_frames(self.file, self.layout, self.sums, self.frames) if self.sums is not None else []
        self.lost += [f"frame {number}" for number in sorted(set(range(self.frames)) - set(found))]
        return found

    def limit(self, checkpoint: Checkpoint) -> None:
        """See no more than was stored when the checkpoint was made."""
        self.frames, self.steps, self.events = checkpoint.frames, checkpoint.steps, checkpoint.events
        self.numbers = self.numbers[: self.frames]
        self.last_step = float(checkpoint.memory["state.clock"][1])

    def results(self) -> Results:
        """All of it."""
        contact = self._contacts()
        frames = StoredFrames(self.folder, self.layout, self.numbers)
        end = _End(self.layout, self.checkpoint, frames)
        steps = StoredSteps(self.folder, self.steps, self.salvage)
        if self.salvage and self.steps and (missing := self.steps - sum(len(block) for block in steps)):
            self.lost.append(f"{missing} of {self.steps} steps")
        return Results(
            summary=self._or("the summary", self._summary, self._unsaved_summary()),
            layout=self.layout,
            history=self._history(),
            contact=contact | {c.label: contact[c.name] for c in self.layout.contacts},
            displacement=end.displacement,
            velocity=end.velocity,
            stress=end.stress,
            internal_variables=end.internal_variables,
            events=self._or("the events", lambda: read_events(self.own, self.events, self.salvage), []),
            iterations=self._or("the iterations", lambda: read_iterations(self.own, self.last_step, self.salvage), []),
            frames=frames,
            folder=self.folder,
            step_source=steps,
            closed=self.closed,
            lost=tuple(self.lost),
        )

    def _summary(self) -> dict[str, Any]:
        """That of the end, or of the last checkpoint when there was no end."""
        if self.closed:
            text = sealed(self.own, "summary").decode()
        elif self.checkpoint is not None:
            text = self.checkpoint.summary
        elif (self.folder / "summary.json").is_file():
            text = (self.folder / "summary.json").read_text()
        else:
            return self._unsaved_summary()
        summary: dict[str, Any] = json.loads(text)
        return summary

    def _unsaved_summary(self) -> dict[str, Any]:
        """What can be said of a run that was killed before it saved its first state."""
        return {
            "format": 1,
            "scene": self.layout.title,
            "status": "interrupted",
            "reason": "the run ended without a word before its first state was saved",
            "parts": dict(self.layout.parts),
            "versions": dict(self.layout.versions),
            "steps": self.steps,
        }

    def _rows(self, name: str, table: Any) -> Floats:
        """The rows of a table that belong to the frames that are read, each as it was written."""
        values = np.asarray(table[: self.frames])[self.numbers]
        if self.sums is not None and not self.salvage:
            for number, row in zip(self.numbers, values, strict=True):
                self.sums.check(number, name, row)
        return values

    def _history(self) -> dict[str, Floats]:
        if "history" not in self.own or not self.numbers:
            return {}
        table = self.own["history"]
        values = self._rows("history", table)
        return {str(name): values[:, i].copy() for i, name in enumerate(table.attrs["columns"])}

    def _contacts(self) -> dict[str, ContactHistory]:
        times = self._history().get("time", np.zeros(0)).tolist()
        found = {}
        for contact in self.layout.contacts:
            table = self._rows(f"curves of {contact.name}", self.own[f"contacts/{contact.name}/curves"])
            found[contact.name] = ContactHistory(list(times), [_curve(values) for values in table])
        return found


def _frame_count(file: Any, salvage: bool) -> int:
    steps = file["VTKHDF/Steps"]
    count, times = int(steps.attrs["NSteps"]), steps["Values"][:]
    if salvage:
        return min(count, len(file["contactlab/history"])) if count else 0
    if len(times) != count or (count and not np.array_equal(times, _times(file["contactlab"], count))):
        raise Damage("the times of the frames are damaged")
    return count


def _times(own: Any, count: int) -> Floats:
    table = own["history"]
    return np.asarray(table[:count, [str(name) for name in table.attrs["columns"]].index("time")])


def _curve(values: Floats) -> ContactCurve:
    columns: dict[str, Any] = {name: values[:, i].copy() for i, name in enumerate(ContactCurve.COLUMNS)}
    return ContactCurve(**columns | {name: columns[name].astype(np.int32) for name in ("state", "chain")})


class _End:
    """Fields at the end of a run: from the newest checkpoint, which has them at every point."""

    def __init__(self, layout: Layout, checkpoint: Checkpoint | None, frames: StoredFrames) -> None:
        memory: Mapping[str, Floats] = checkpoint.memory if checkpoint is not None else {}
        last = frames[-1] if not memory and len(frames) else None
        self.displacement = last.displacement if last else memory.get("state.displacement", _no_field(layout)).copy()
        self.velocity = last.velocity if last else memory.get("state.velocity", np.zeros((0, 2))).copy()
        self.stress = {body.name: _points(memory, "stress", body) for body in layout.bodies} if memory else {}
        self.internal_variables = {
            body.name: _variables(memory, body) for body in layout.bodies if body.internal_variables and memory
        }


def _no_field(layout: Layout) -> Floats:
    return np.zeros_like(layout.nodes)


def _blocks(memory: Mapping[str, Floats], what: str, body: BodyLayout) -> list[Floats]:
    found: list[Floats] = []
    while (name := f"{what}.{body.name}.{len(found)}") in memory:
        found.append(memory[name])
    return found


def _points(memory: Mapping[str, Floats], what: str, body: BodyLayout) -> Floats:
    """(n, q, components) from blocks (components, q B), point-major."""
    blocks = _blocks(memory, what, body)
    points = sum(block.shape[1] for block in blocks) // len(body.cells)
    return np.concatenate([b.reshape(len(b), points, -1).transpose(2, 1, 0) for b in blocks])


def _variables(memory: Mapping[str, Floats], body: BodyLayout) -> dict[str, Floats]:
    stress, flat = _blocks(memory, "stress", body), memory[f"state.history.{body.name}"].ravel()
    points = sum(block.shape[1] for block in stress) // len(body.cells)
    count, begin = len(flat) // (points * len(body.cells)), 0
    parts: list[Floats] = []
    for block in stress:
        size = count * block.shape[1]
        parts.append(flat[begin : begin + size].reshape(count, points, -1).transpose(2, 1, 0))
        begin += size
    values = np.concatenate(parts)
    return {name: values[:, :, i].copy() for i, name in enumerate(body.internal_variables)}


class StoredFrames(Sequence[Frame]):
    """The stored frames of a run with these numbers, each read from the file when it is asked for."""

    def __init__(self, folder: Path, layout: Layout, numbers: Sequence[int]) -> None:
        self.folder, self.layout, self.numbers = folder, layout, numbers
        self.total = len(numbers)

    def __len__(self) -> int:
        return self.total

    @overload
    def __getitem__(self, number: int) -> Frame: ...
    @overload
    def __getitem__(self, number: slice) -> list[Frame]: ...
    def __getitem__(self, number: int | slice) -> Frame | list[Frame]:
        """Frame `number`, negative ones from the end. Raises RequestError where it is damaged."""
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(self.total))]
        if not -self.total <= number < self.total:
            raise IndexError(f"frame {number} of {self.total}")
        with opened(self.folder) as file, damage_told(self.folder):
            return self._read(file, StoredSums(file["contactlab"]), self.numbers[number])

    def __iter__(self) -> Iterator[Frame]:
        with opened(self.folder) as file:
            with damage_told(self.folder):
                sums = StoredSums(file["contactlab"]) if self.total else None
            for number in self.numbers:
                with damage_told(self.folder):
                    frame = self._read(file, sums, number)
                yield frame

    def _read(self, file: Any, sums: StoredSums | None, number: int) -> Frame:
        assert sums is not None
        grid, own = file["VTKHDF"], file["contactlab"]
        points = slice(number * len(self.layout.nodes), (number + 1) * len(self.layout.nodes))
        names = [str(name) for name in own["history"].attrs["columns"]]
        row = sums.check(number, "history", own["history"][number])
        scalars = dict(zip(names, row.tolist(), strict=True))
        fields = ("displacement", *(("velocity",) if self.layout.has_velocity else ()))
        vectors = {name: sums.check(number, name, grid["PointData"][name][points])[:, :2] for name in fields}
        return Frame(
            number=number,
            step=int(scalars["step"]),
            time=scalars["time"],
            scalars=scalars,
            curves={c.name: _curve(self._curve(own, sums, c.name, number)) for c in self.layout.contacts},
            displacement=np.ascontiguousarray(vectors["displacement"]),
            velocity=np.ascontiguousarray(vectors.get("velocity", np.zeros((0, 2)))),
            cells=self._cells(grid["CellData"], sums, number),
        )

    def _curve(self, own: Any, sums: StoredSums, contact: str, number: int) -> Floats:
        values: Floats = sums.check(number, f"curves of {contact}", own[f"contacts/{contact}/curves"][number])
        return values

    def _cells(self, data: Any, sums: StoredSums, number: int) -> dict[str, dict[str, Floats]]:
        total = sum(len(body.cells) for body in self.layout.bodies)
        here = slice(number * total, (number + 1) * total)
        shown = dict.fromkeys(name for body in self.layout.bodies for name in body.shown_variables)
        fields = {name: sums.check(number, name, data[name][here]) for name in ("stress", "von_mises", *shown)}
        found, begin = {}, 0
        for body in self.layout.bodies:
            part = slice(begin, begin + len(body.cells))
            begin = part.stop
            names = ("von_mises", *body.shown_variables)
            found[body.name] = {"stress": fields["stress"][part, :4]} | {name: fields[name][part] for name in names}
        return found


class StoredSteps(Sequence[Floats]):
    """Scalars of every step in blocks (b, columns), read when they are asked for; `salvage`: those that are whole."""

    def __init__(self, folder: Path, count: int, salvage: bool = False) -> None:
        self.folder, self.total, self.salvage = folder, count, salvage

    def __len__(self) -> int:
        return -(-self.total // STEPS_AT_ONCE)

    @overload
    def __getitem__(self, number: int) -> Floats: ...
    @overload
    def __getitem__(self, number: slice) -> list[Floats]: ...
    def __getitem__(self, number: int | slice) -> Floats | list[Floats]:
        """Block `number`. Raises RequestError where it is damaged."""
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(len(self)))]
        if not 0 <= number < len(self):
            raise IndexError(f"block {number} of {len(self)}")
        begin = number * STEPS_AT_ONCE
        end = min(begin + STEPS_AT_ONCE, self.total)
        with opened(self.folder) as file:
            if self.salvage:
                return self._whole(file, begin, end)
            with damage_told(self.folder):
                block: Floats = file["contactlab/steps"][begin:end]
                good = whole_steps(file, begin, end)
                if not good.all():
                    raise Damage(f"{np.count_nonzero(~good)} of {self.total} steps are damaged")
                return block

    def _whole(self, file: Any, begin: int, end: int) -> Floats:
        try:
            block: Floats = np.asarray(file["contactlab/steps"][begin:end])
            return np.asarray(block[whole_steps(file, begin, end)])
        except BROKEN:
            return np.zeros((0, file["contactlab/steps"].shape[1]))
