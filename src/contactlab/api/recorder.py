"""Recorders (output writers): they write stored results of a run, and change nothing in it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import Event, Frame, Iterate, IterationRow, Layout, StoredRun

FAILURE, WARNING = "failure", "warning"
"""Reason for storing all fields of the last steps: the run failed, or a guard warned for the first time."""


class Recording(ABC):
    """The recording of one run. Subclasses must define `frame` and `close`.

    An OSError (disk full) of a recording that keeps the run's state stops the run and keeps the written data; after
    any other exception, and an OSError of other recordings, the run continues without this recorder, with a warning.

    keeps_state  True if `save` stores its arguments, so that the run can be resumed
    """

    keeps_state: ClassVar[bool] = False

    @abstractmethod
    def frame(self, frame: Frame) -> None:
        """Record a frame that was just stored."""

    def steps(self, block: Floats) -> None:  # noqa: B027 - optional
        """Take the scalars of the steps since the last call (b, len(layout.steps)); the array is reused.

        Called for recorders with `every_step`, before each frame and whenever the buffer is full.
        """

    def contact_steps(self, block: Mapping[str, np.ndarray]) -> None:  # noqa: B027
        """Take rows of the contact record of the same steps, by the name of each contact; they may be kept.

        Their fields follow `contactlab.api.contact_steps.contact_record`. Called for recorders with
        `every_contact`, in runs that record contact.
        """

    def event(self, event: Event) -> None:  # noqa: B027
        """Record an event when it happens."""

    def iterations(self, rows: Sequence[IterationRow]) -> None:  # noqa: B027
        """Take the Newton iterations of one attempted step; never called in explicit runs."""

    def iterates(self, some: Sequence[Iterate]) -> None:  # noqa: B027
        """Take bodies and contacts after iterations whose rows were given before; they may be kept.

        Called for recorders with `every_iterate`, in implicit runs, for as many as `record.budget` has room for.
        """

    def last_steps(self, end: str, frames: Sequence[Frame]) -> None:  # noqa: B027
        """Take frames of each of the last steps before `end`, which is FAILURE or WARNING; each is given once.

        Called for recorders with `every_field`, in runs that fail or give a warning.
        """

    def news(self) -> Sequence[str]:
        """Return sentences for the log of the run since the frame before; called after each frame."""
        return ()

    def facts(self) -> Mapping[str, Any]:
        """Return entries for the summary of the run, such as what was left out; called before `close`."""
        return {}

    def save(self, memory: Mapping[str, Floats], summary: Mapping[str, Any]) -> None:  # noqa: B027
        """Keep all that a restart needs. Called at intervals, at an interrupt, and at the end."""

    @abstractmethod
    def close(self, summary: Mapping[str, Any]) -> None:
        """Finish, also after a failed run; `summary` is the content of `summary.json`."""


class Recorder(ABC):
    """Makes recordings. Subclasses are frozen dataclasses; their fields are the TOML keys.

    by_default  used if a scene names no recorders
    every_step  its recordings take `steps`
    every_contact  its recordings take `contact_steps`
    every_iterate  its recordings take `iterates`
    every_field  its recordings take `last_steps`
    stores_results  results are read back from its recordings, and other recordings are made from them
    shown_file  name of the file that `show` opens, made of the stored results after a run, if they are
                stored; empty if there is nothing to show
    """

    by_default: ClassVar[bool] = False
    every_step: ClassVar[bool] = False
    every_contact: ClassVar[bool] = False
    every_iterate: ClassVar[bool] = False
    every_field: ClassVar[bool] = False
    stores_results: ClassVar[bool] = False
    shown_file: ClassVar[str] = ""

    @property
    def on_view(self) -> bool:
        """True if the file is made at the first view, in runs whose results another recorder stores."""
        return False

    def check(self, layout: Layout) -> None:  # noqa: B027 - optional
        """Raise ValueError if a run of this layout lacks what the fields ask for.

        Called before the first step for recorders that work `on_view`; of all others `open` does it.
        """

    @abstractmethod
    def open(self, folder: Path, layout: Layout) -> Recording:
        """Start a recording in `folder`. Import heavy libraries here."""

    def disk_bytes(self, layout: Layout, steps: float, memory: float) -> float:
        """Return the bytes that a run will leave on the disk, 0 if unknown. A run begins only if there is room.

        The run has `layout.frames` frames and about `steps` steps; the state for a restart has `memory` bytes.
        """
        return 0.0

    def resume(self, folder: Path, layout: Layout, run: StoredRun) -> Recording:
        """Continue an interrupted run: by default with a new recording of all that `run` has stored."""
        recording = self.open(folder, layout)
        replay(run, recording, self.every_step, self.every_contact, self.every_field, self.every_iterate)
        return recording

    def compared(self, folder: Path, runs: Mapping[str, StoredRun]) -> None:  # noqa: B027
        """Act on a finished comparison, given its folder and its runs by the values in which they differ."""

    def show(self, file: Path, png: Path | None, step: int | None, iteration: int | None = None) -> None:
        """Show `file` on the screen, or write a picture of it to `png`: at `step`, at Newton's `iteration`, or its end.

        Raises RuntimeError, with what to install, if this machine cannot show it, and ValueError
        if there is no such step or iteration.
        """
        raise NotImplementedError(f"{type(self).__name__} has nothing to show")

    def inline(self, file: Path) -> Any:
        """Return an object that a notebook displays for `file`; None if it cannot."""
        return None


def replay(
    run: StoredRun,
    recording: Recording,
    steps: bool,
    contact: bool,
    fields: bool = False,
    iterates: bool = False,
) -> None:
    """Give `recording` everything that `run` has stored; steps, contact, fields and iterates if it takes them."""
    if steps:
        for block in run.step_blocks():
            recording.steps(block)
    if contact:
        for rows in run.contact_step_blocks():
            recording.contact_steps(rows)
    for event in run.events:
        recording.event(event)
    recording.iterations(run.iterations)
    if iterates:
        recording.iterates(run.iterates)
    for end, last in run.last_steps.items() if fields else ():
        recording.last_steps(end, last)
    frames: Sequence[Frame] = run.frames
    for frame in frames:
        recording.frame(frame)
