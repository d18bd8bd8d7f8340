"""Recorders: they see what a run stores and change nothing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import Event, Frame, IterationRow, Layout, StoredRun

FAILURE, WARNING = "failure", "warning"
"""Why the last steps are stored whole: the run failed, or a guard warned for the first time."""


class Recording(ABC):
    """What a recorder has opened for one run. `frame` and `close` must be given.

    An OSError (disk full) from any method stops the run with what is written; after any other
    exception the run goes on without this recorder, with a warning.

    keeps_state  `save` keeps what it is given, so that the run can be taken up again
    """

    keeps_state: ClassVar[bool] = False

    @abstractmethod
    def frame(self, frame: Frame) -> None:
        """Record a frame that was just stored."""

    def steps(self, block: Floats) -> None:  # noqa: B027 - nothing is a fine answer
        """Take the scalars of the steps since the last call (b, len(layout.steps)); the array is reused.

        Called for recorders with `every_step`, before each frame and whenever the buffer is full.
        """

    def contact_steps(self, block: Mapping[str, np.ndarray]) -> None:  # noqa: B027
        """Take rows of the contact record, those of the same steps of every contact by its name; they may be kept.

        Their fields are those of `contactlab.api.contact_steps.contact_record`. Called for recorders with
        `every_contact`, in runs that record contact.
        """

    def event(self, event: Event) -> None:  # noqa: B027
        """Record an event when it happens."""

    def iterations(self, rows: Sequence[IterationRow]) -> None:  # noqa: B027
        """Take the Newton iterations of one attempted step; never called in explicit runs."""

    def last_steps(self, end: str, frames: Sequence[Frame]) -> None:  # noqa: B027
        """Take a frame of every one of the last steps before `end`, one of FAILURE and WARNING; each comes once.

        Called for recorders with `every_field`, in runs that fail or are warned of.
        """

    def save(self, memory: Mapping[str, Floats], summary: Mapping[str, Any]) -> None:  # noqa: B027
        """Keep all that a restart needs. Called now and then, at an interrupt, and at the end."""

    @abstractmethod
    def close(self, summary: Mapping[str, Any]) -> None:
        """Finish, also after a failed run; `summary` is the content of `summary.json`."""


class Recorder(ABC):
    """Makes recordings. Subclasses are frozen dataclasses; their fields are the TOML keys.

    by_default  used where a scene names no recorders
    every_step  its recordings want `steps`
    every_contact  its recordings want `contact_steps`
    every_field  its recordings want `last_steps`
    shown_file  name of the file that `show` opens; empty where there is nothing to show
    """

    by_default: ClassVar[bool] = False
    every_step: ClassVar[bool] = False
    every_contact: ClassVar[bool] = False
    every_field: ClassVar[bool] = False
    shown_file: ClassVar[str] = ""

    @abstractmethod
    def open(self, folder: Path, layout: Layout) -> Recording:
        """Start a recording in `folder`. Import what is heavy here."""

    def disk_bytes(self, layout: Layout, steps: float, memory: float) -> float:
        """How much a run will leave on the disk, in bytes; 0 where nobody can say. It begins where there is room.

        The run has `layout.frames` frames and about so many steps, and a restart needs `memory` bytes of it.
        """
        return 0.0

    def resume(self, folder: Path, layout: Layout, run: StoredRun) -> Recording:
        """Go on with an interrupted run: by default a new recording of all that `run` has stored."""
        recording = self.open(folder, layout)
        replay(run, recording, steps=self.every_step, contact=self.every_contact, fields=self.every_field)
        return recording

    def compared(self, folder: Path, runs: Mapping[str, StoredRun]) -> None:  # noqa: B027
        """Called once after a comparison, with its folder and its runs by what tells them apart."""

    def show(self, file: Path, png: Path | None, step: int | None) -> None:
        """Let a person look at `file`, or write a picture of it to `png`: at `step`, or at its end.

        Raises RuntimeError, saying what to install, where this machine cannot show it, and ValueError
        where there is no such step.
        """
        raise NotImplementedError(f"{type(self).__name__} has nothing to show")

    def inline(self, file: Path) -> Any:
        """What a notebook displays of `file`; None where it cannot."""
        return None


def replay(run: StoredRun, recording: Recording, steps: bool, contact: bool, fields: bool = False) -> None:
    """Give `recording` everything that `run` has stored; `steps`, `contact` and `fields` where it is for those."""
    if steps:
        for block in run.step_blocks():
            recording.steps(block)
    if contact:
        for rows in run.contact_step_blocks():
            recording.contact_steps(rows)
    for event in run.events:
        recording.event(event)
    recording.iterations(run.iterations)
    for end, last in run.last_steps.items() if fields else ():
        recording.last_steps(end, last)
    frames: Sequence[Frame] = run.frames
    for frame in frames:
        recording.frame(frame)
