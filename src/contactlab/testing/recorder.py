"""Checks of recorders."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from contactlab.api import Event, Floats, Frame, IterationRow, Layout, Recorder, Recording
from contactlab.api.frame import BodyLayout
from contactlab.results.step_columns import step_columns
from contactlab.testing.assertions import Check, NotApplicable, require, untouched

STEPS_PER_FRAME = 5
IN_SINGLE = 1e-4
"""Share of the largest value of a field: files keep 14 significant bits of most."""
SUMMARY: dict[str, Any] = {"format": 1, "status": "finished", "reason": "", "steps": 3 * STEPS_PER_FRAME}


@dataclass
class SmallRun:
    """A square that is pulled, in four frames. Implements `contactlab.api.StoredRun`.

    bodies  names of its two cells, or of both together
    """

    bodies: tuple[str, ...] = ("square",)
    frames: list[Frame] = field(default_factory=list)
    events: list[Event] = field(default_factory=lambda: [Event(5, 0.5, "warning", "something was seen")])
    iterations: list[IterationRow] = field(default_factory=list)
    last_steps: dict[str, list[Frame]] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=lambda: dict(SUMMARY))

    def __post_init__(self) -> None:
        self.frames = self.frames or [_frame(number, self.bodies) for number in range(4)]

    @property
    def layout(self) -> Layout:
        """Two cells side by side, without supports and contacts."""
        nodes = np.array([[i, j] for j in range(2) for i in range(3)], float)
        cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4]], np.int32)
        parts = zip(self.bodies, np.split(cells, len(self.bodies)), strict=True)
        bodies = tuple(BodyLayout(name, "element", "law", own) for name, own in parts)
        steps = step_columns((), ())
        return Layout("format = 1\n", "square", "mm N s t", nodes, bodies, (), (), {}, {}, steps, True, 3)

    @property
    def step_count(self) -> int:
        """Steps between the first frame and the last."""
        return (len(self.frames) - 1) * STEPS_PER_FRAME

    def step_blocks(self) -> Iterator[Floats]:
        """Blocks of steps as a run gives them to a recorder before each frame."""
        for frame in self.frames[1:]:
            yield _steps(frame.number)

    @property
    def contact_step_count(self) -> int:
        """No contact, no record of one."""
        return 0

    def contact_step_blocks(self) -> Iterator[Mapping[str, np.ndarray]]:
        """Give nothing, as there is no contact."""
        return iter(())


def _steps(number: int) -> Floats:
    """Scalars (5, columns) of the steps that end with a frame."""
    columns = step_columns((), ())
    block = np.zeros((STEPS_PER_FRAME, len(columns)))
    step = (number - 1) * STEPS_PER_FRAME + 1 + np.arange(STEPS_PER_FRAME)
    for name, values in {"step": step, "time": 0.1 * step, "dt": 0.1}.items():
        block[:, columns.index(name)] = np.asarray(values)
    return block


def _frame(number: int, bodies: tuple[str, ...]) -> Frame:
    step = number * STEPS_PER_FRAME
    moved = np.full((6, 2), 0.01 * number)
    few = 2 // len(bodies)
    cells = {n: {"stress": np.full((few, 4), float(number)), "von_mises": np.full(few, float(number))} for n in bodies}
    scalars = {"step": float(step), "time": 0.1 * step, "energy.kinetic": 0.0, "sweeps": 0.0}
    return Frame(number, step, 0.1 * step, scalars, {}, moved, moved.copy(), cells)


def record(recorder: Recorder, recording: Recording, run: SmallRun, frames: slice = slice(None)) -> None:
    """Give `recording` frames of the run as a simulation does: steps first, in an array that is used again."""
    for frame in run.frames[frames]:
        if recorder.every_step and frame.number:
            block = _steps(frame.number)
            recording.steps(block)
            block[:] = np.nan
        recording.frame(frame)
    for event in run.events:
        recording.event(event)


def leaves_something(recorder: Recorder) -> None:
    """A recorded run leaves a file in its folder, and nothing outside it."""
    with TemporaryDirectory() as place:
        folder = Path(place, "run")
        folder.mkdir()
        run = SmallRun()
        recording = recorder.open(folder, run.layout)
        record(recorder, recording, run)
        recording.close(SUMMARY)
        left_open = _open_in(Path(place))
        require(not left_open, f"closed, and still open: {', '.join(left_open)}")
        require(
            any(file.stat().st_size for file in folder.rglob("*") if file.is_file()),
            "the folder of the run has no file with anything in it",
        )
        beside = [file.name for file in Path(place).iterdir() if file != folder]
        require(not beside, f"files outside the folder of the run: {', '.join(beside)}")
        shown = recorder.shown_file
        require(not shown or (folder / shown).is_file(), f"shown_file is {shown}, which was not written")


def _open_in(folder: Path) -> list[str]:
    """Files below a folder that this process has open, if the system reports them."""
    links = Path("/proc/self/fd")
    if not links.is_dir():
        return []
    targets = (os.path.realpath(link) for link in links.iterdir())
    return sorted(Path(target).name for target in targets if Path(folder).resolve() in Path(target).parents)


def changes_nothing(recorder: Recorder) -> None:
    """Frames belong to the run, which keeps using their arrays."""
    run = SmallRun()
    for frame in run.frames:  # numbers in no order: what sorts or takes sizes in place leaves others
        for values in (frame.displacement, frame.velocity, *frame.cells["square"].values()):
            values[...] += np.cos(2.0 * np.arange(values.size)).reshape(values.shape)
    arrays = {
        f"{name} of frame {f.number}": values
        for f in run.frames
        for name, values in {"displacement": f.displacement, "velocity": f.velocity, **f.cells["square"]}.items()
    }
    with TemporaryDirectory() as place, untouched(**arrays):
        recording = recorder.open(Path(place), run.layout)
        record(recorder, recording, run)
        recording.close(SUMMARY)


def closes_after_a_failure(recorder: Recorder) -> None:
    """A run may fail in its first step: the recording is closed with a single frame, or none at all."""
    for frames in (0, 1):
        with TemporaryDirectory() as place:
            run = SmallRun()
            recording = recorder.open(Path(place), run.layout)
            record(recorder, recording, run, slice(frames))
            recording.close(SUMMARY | {"status": "diverged", "reason": "step 1: it was made to", "steps": 1})


def records_twice(recorder: Recorder) -> None:
    """A recorder keeps nothing of a run: two recordings of it, open together or in the same folder, are equal."""
    run = SmallRun()
    with TemporaryDirectory() as first, TemporaryDirectory() as second:
        both = [recorder.open(Path(place), run.layout) for place in (first, second)]
        left = []
        for recording, place in zip(both, (first, second), strict=True):
            record(recorder, recording, run)
            recording.close(SUMMARY)
            left.append(_contents(place))
        record(recorder, again := recorder.open(Path(first), run.layout), run)
        again.close(SUMMARY)
        left.append(_contents(first))
    for which, other in (("a second", left[1]), ("a second recording in its folder", left[2])):
        require(left[0].keys() == other.keys(), f"the first leaves {sorted(left[0])}, {which} {sorted(other)}")
        for name, size in left[0].items():
            # time stamps and names of folders may be in it
            most = min(0.05 * size + 64, 0.5 * size)
            require(abs(other[name] - size) <= most, f"{name}: {size} bytes, of {which} {other[name]}")


def _contents(place: str) -> dict[str, int]:
    return {file.name: file.stat().st_size for file in Path(place).iterdir()}


def everything_leaves_a_trace(recorder: Recorder) -> None:
    """Every frame, and every step if it takes steps, changes what is written, apart from time stamps."""
    for number in range(4):
        _told(recorder, f"time, scalars and displacements of frame {number}", number, None)
    if recorder.every_step:
        for step in (0, STEPS_PER_FRAME - 1):
            _told(recorder, f"the scalars of step {step + 1} of a frame", None, step)


def _told(recorder: Recorder, what: str, frame: int | None, step: int | None) -> None:
    """Other numbers in a frame or step give other bytes. Bytes that always change, as time stamps, do not count."""
    other = SmallRun()
    if frame is not None:
        was = other.frames[frame]
        was.displacement[2, 1] += 0.5
        scalars = {name: value + 0.25 for name, value in was.scalars.items()}
        other.frames[frame] = replace(was, time=was.time + 0.01, scalars=scalars)
    runs = ((SmallRun(), None), (other, step), (other, step), (SmallRun(), None))
    before, one, two, after = (_written(recorder, run, spoilt) for run, spoilt in runs)
    if _sizes(before) != _sizes(after):
        raise NotApplicable("two recordings of the same run have different files or sizes")
    if _sizes(one) != _sizes(before):
        return
    steady = [(_bytes(before[n]) == _bytes(after[n])) & (_bytes(one[n]) == _bytes(two[n])) for n in before]
    changed = (np.any(same & (_bytes(one[n]) != _bytes(before[n]))) for n, same in zip(before, steady, strict=True))
    require(any(changed), f"{what} do not change what is written")


def bodies_are_told_apart(recorder: Recorder) -> None:
    """Files follow the stresses of every body, or of none."""
    bodies = ("first", "second")

    def written(spoilt: str = "") -> dict[str, bytes]:
        run = SmallRun(bodies)
        for frame in run.frames if spoilt else ():
            for values in frame.cells[spoilt].values():
                values += 7.5
        return _written(recorder, run)

    plain = written()
    if plain != written():
        raise NotApplicable("two recordings of the same run differ")
    seen = [name for name in bodies if written(name) != plain]
    require(len(seen) != 1, f"only the stresses of the {''.join(seen)} of two bodies change what is written")


def _sizes(files: dict[str, bytes]) -> dict[str, int]:
    return {name: len(content) for name, content in files.items()}


def _bytes(data: bytes) -> np.ndarray:
    return np.frombuffer(data, np.uint8)


def _written(recorder: Recorder, run: SmallRun, spoilt: int | None = None) -> dict[str, bytes]:
    """Contents of the files of a recording; `spoilt` is a step whose scalars are others."""
    with TemporaryDirectory() as place:
        recording = recorder.open(Path(place), run.layout)
        for frame in run.frames:
            if recorder.every_step and frame.number:
                block = _steps(frame.number)
                if spoilt is not None:
                    block[spoilt, 2:] += 0.25
                recording.steps(block)
                block[:] = 0.0  # the array is used again
            recording.frame(frame)
        recording.close(SUMMARY)
        return {str(p.relative_to(place)): p.read_bytes() for p in Path(place).rglob("*") if p.is_file()}


def is_read_back(recorder: Recorder) -> None:
    """Results that are read from its file are what it was given, as far as single precision goes."""
    from contactlab.results.load import load_results
    from contactlab.results.result_file import FILE

    run = SmallRun()
    with TemporaryDirectory() as place:
        recording = recorder.open(Path(place), run.layout)
        record(recorder, recording, run)
        recording.close(SUMMARY)
        if not Path(place, FILE).is_file():
            raise NotApplicable(f"it writes no {FILE}, from which results are read")
        frames = list(load_results(place).frames)
    require(len(frames) == len(run.frames), f"{len(run.frames)} frames were given, {len(frames)} are read back")
    for found, given in zip(frames, run.frames, strict=True):
        require(found.step == given.step, f"frame {given.number} is of step {found.step}, not {given.step}")
        _near(found.displacement, given.displacement, f"displacements of frame {given.number}")
        for name, values in given.cells["square"].items():
            _near(found.cells["square"][name], values, f"{name} of frame {given.number}")


def _near(found: Floats, given: Floats, what: str) -> None:
    off = float(np.abs(found - given).max())
    most = IN_SINGLE * float(np.abs(given).max())
    require(off <= most, f"{what} are read back with an error of {off:.2e}, allowed {most:.2e}")


CHECKS: tuple[Check, ...] = (
    leaves_something,
    changes_nothing,
    closes_after_a_failure,
    records_twice,
    is_read_back,
    everything_leaves_a_trace,
    bodies_are_told_apart,
)
"""All checks of recorders."""
