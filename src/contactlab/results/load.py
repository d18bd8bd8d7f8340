"""Results read back from `results.vtkhdf`, by h5py and NumPy alone."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import BodyLayout, ContactCurve, Frame, Layout
from contactlab.errors import RequestError
from contactlab.results.checkpoint_slots import Checkpoint, Slots
from contactlab.results.event_table import read_events
from contactlab.results.iteration_table import read_iterations
from contactlab.results.layout_file import FORMAT, read_layout
from contactlab.results.results import ContactHistory, Results

FILE = "results.vtkhdf"
STEPS_AT_ONCE = 65536


def load_results(folder: str | Path) -> Results:
    """The results of the run in `folder`, equal to what `simulate` gave back; as far as it went if it was killed.

    Raises RequestError where there is no readable `results.vtkhdf`.
    """
    with opened(Path(folder)) as file:
        return _Reader(file, Path(folder)).results()


def load_checkpoint(folder: Path) -> tuple[Results, Checkpoint] | None:
    """The newest checkpoint in `folder` and the run up to it; None if nothing was saved before the run stopped."""
    with opened(folder) as file:
        reader = _Reader(file, folder)
        if reader.checkpoint is None:
            return None
        reader.limit(reader.checkpoint)
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
        raise RequestError(f"the file cannot be read: {error}", where=str(path)) from error
    if "contactlab" not in file or "VTKHDF" not in file:
        file.close()
        raise RequestError("the file was not written by contactlab", where=str(path))
    found = file["contactlab"].attrs.get("format")
    if found != FORMAT:
        file.close()
        raise RequestError(
            "the file was written by another version of contactlab",
            where=str(path),
            got=f"format {found}",
            allowed=f"format {FORMAT}",
            hint="read it with the version in its summary.json, or make the run again from its scene.toml",
        )
    return file


class _Reader:
    """One open file."""

    def __init__(self, file: Any, folder: Path) -> None:
        self.file, self.folder, self.own = file, folder, file["contactlab"]
        self.layout = read_layout(self.own)
        steps = file["VTKHDF/Steps"]
        # a kill can fall between two writes of one flush: a frame is there once both say so
        self.frames = min(int(steps.attrs["NSteps"]), len(steps["Values"]))
        self.steps = int(self.own["steps"].attrs["count"])
        self.events = len(self.own["events/step"])
        self.last_step = math.inf
        slots = Slots.of(self.own)
        self.checkpoint = slots.newest(self.frames, self.steps, self.events) if slots is not None else None
        saved = slots.serial if slots is not None else 0
        # the summary of a run that was taken up again is that of an earlier end
        self.closed = "summary" in self.own and int(self.own["summary"].attrs.get("serial", saved)) >= saved

    def limit(self, checkpoint: Checkpoint) -> None:
        """See no more than was stored when the checkpoint was made."""
        self.frames, self.steps, self.events = checkpoint.frames, checkpoint.steps, checkpoint.events
        self.last_step = float(checkpoint.memory["state.clock"][1])

    def results(self) -> Results:
        contact = self._contacts()
        end = _End(self.layout, self.checkpoint, self._frames())
        return Results(
            summary=self._summary(),
            layout=self.layout,
            history=self._history(),
            contact=contact | {c.label: contact[c.name] for c in self.layout.contacts},
            displacement=end.displacement,
            velocity=end.velocity,
            stress=end.stress,
            internal_variables=end.internal_variables,
            events=read_events(self.own, self.events),
            iterations=read_iterations(self.own, self.last_step),
            frames=self._frames(),
            folder=self.folder,
            step_source=StoredSteps(self.folder, self.steps),
            closed=self.closed,
        )

    def _summary(self) -> dict[str, Any]:
        """That of the end, or of the last checkpoint when there was no end."""
        if self.closed:
            text = self.own["summary"][()].decode()
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

    def _history(self) -> dict[str, Floats]:
        if "history" not in self.own:
            return {}
        table = self.own["history"]
        values = table[: self.frames]
        return {str(name): values[:, i].copy() for i, name in enumerate(table.attrs["columns"])}

    def _contacts(self) -> dict[str, ContactHistory]:
        times = self.file["VTKHDF/Steps/Values"][: self.frames].tolist()
        found = {}
        for contact in self.layout.contacts:
            table = self.own[f"contacts/{contact.name}/curves"][: self.frames]
            found[contact.name] = ContactHistory(list(times), [_curve(values) for values in table])
        return found

    def _frames(self) -> StoredFrames:
        return StoredFrames(self.folder, self.layout, self.frames)


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
    """The stored frames of a run, each read from the file when it is asked for."""

    def __init__(self, folder: Path, layout: Layout, count: int) -> None:
        self.folder, self.layout, self.total = folder, layout, count

    def __len__(self) -> int:
        return self.total

    @overload
    def __getitem__(self, number: int) -> Frame: ...
    @overload
    def __getitem__(self, number: slice) -> list[Frame]: ...
    def __getitem__(self, number: int | slice) -> Frame | list[Frame]:
        """Frame `number`, negative ones from the end."""
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(self.total))]
        if not -self.total <= number < self.total:
            raise IndexError(f"frame {number} of {self.total}")
        with opened(self.folder) as file:
            return self._read(file, number % self.total)

    def __iter__(self) -> Iterator[Frame]:
        with opened(self.folder) as file:
            for number in range(self.total):
                yield self._read(file, number)

    def _read(self, file: Any, number: int) -> Frame:
        grid, own = file["VTKHDF"], file["contactlab"]
        points = slice(number * len(self.layout.nodes), (number + 1) * len(self.layout.nodes))
        row, names = own["history"][number], [str(name) for name in own["history"].attrs["columns"]]
        scalars = dict(zip(names, row.tolist(), strict=True))
        velocity = grid["PointData/velocity"][points, :2] if self.layout.has_velocity else np.zeros((0, 2))
        return Frame(
            number=number,
            step=int(scalars["step"]),
            time=scalars["time"],
            scalars=scalars,
            curves={c.name: _curve(own[f"contacts/{c.name}/curves"][number]) for c in self.layout.contacts},
            displacement=grid["PointData/displacement"][points, :2],
            velocity=velocity,
            cells=self._cells(grid["CellData"], number),
        )

    def _cells(self, data: Any, number: int) -> dict[str, dict[str, Floats]]:
        total = sum(len(body.cells) for body in self.layout.bodies)
        found, begin = {}, number * total
        for body in self.layout.bodies:
            part = slice(begin, begin + len(body.cells))
            begin = part.stop
            names = ("von_mises", *body.shown_variables)
            found[body.name] = {"stress": data["stress"][part, :4]} | {name: data[name][part] for name in names}
        return found


class StoredSteps(Sequence[Floats]):
    """Scalars of every step in blocks (b, columns), read when they are asked for."""

    def __init__(self, folder: Path, count: int) -> None:
        self.folder, self.total = folder, count

    def __len__(self) -> int:
        return -(-self.total // STEPS_AT_ONCE)

    @overload
    def __getitem__(self, number: int) -> Floats: ...
    @overload
    def __getitem__(self, number: slice) -> list[Floats]: ...
    def __getitem__(self, number: int | slice) -> Floats | list[Floats]:
        """Block `number`."""
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(len(self)))]
        if not 0 <= number < len(self):
            raise IndexError(f"block {number} of {len(self)}")
        with opened(self.folder) as file:
            begin = number * STEPS_AT_ONCE
            block: Floats = file["contactlab/steps"][begin : min(begin + STEPS_AT_ONCE, self.total)]
            return block
