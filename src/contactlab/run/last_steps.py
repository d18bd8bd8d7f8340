"""The steps before a failure, or before the first warning of a guard, with all of their fields.

Explicit runs have no overhead while they go well: states are kept at intervals, and the steps after them are
repeated in a new model, which gives the same bits. Implicit steps take long enough to store each of them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from contactlab.api import Frame, Layout, Step, StepStatus
from contactlab.api.recorder import FAILURE, WARNING
from contactlab.model.model import Model
from contactlab.results.frame import frame_of
from contactlab.results.journal import Journal
from contactlab.results.last_steps_file import drop_last_steps, has_last_steps
from contactlab.results.record_plan import MEGABYTE
from contactlab.results.sample import take_sample
from contactlab.run.guards import EVERY
from contactlab.run.kept_states import KeptStates
from contactlab.scene.keys import Record

LENGTH = 200  # steps, where the scene names none
# what a frame takes compressed on the disk at most, and in memory, of what it is in a file
STORED, IN_MEMORY = 0.5, 2.0
MEMORY = 128.0  # MB that the frames of the last steps may take before they are stored


def length_of(record: Record, layout: Layout) -> int:
    """Number of steps that a scene stores with all fields and its budget has room for; 0: none."""
    from contactlab.results.grid_file import frame_bytes

    wanted = LENGTH if record.last is None else record.last
    room = min(MEMORY / IN_MEMORY, layout.budget / STORED)
    return min(wanted, int(room * MEGABYTE / max(1.0, frame_bytes(layout))))


class LastSteps:
    """Takes the frames of the last `length` steps of one run, and hands them to a journal.

    rebuild      gives another model of the same scene, as it was before the first step
    share        the fraction of the run that is done at a time [s]
    all_warnings  warnings judged at frames and at the end count, not only warnings of guards
    """

    def __init__(
        self,
        model: Model,
        length: int,
        rebuild: Callable[[], Model],
        share: Callable[[float], float],
        all_warnings: bool = False,
    ) -> None:
        self.model, self.length, self.rebuild, self.share = model, length, rebuild, share
        self.all_warnings = all_warnings
        self.frames: deque[Frame] = deque(maxlen=length)
        self.known: int | None = None

    @property
    def states(self) -> int:
        """Number of states that an explicit run must keep."""
        return 1 + -(-self.length // EVERY)

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """Callbacks after each accepted step: none in explicit runs."""
        return () if self.model.explicit else (self._seen,)

    def _seen(self, step: Step, dt: float) -> None:
        self.frames.append(self._frame(self.model, step))

    def judged(self, journal: Journal, kept: KeptStates) -> None:
        """Skip warnings since the last look, which come from a frame or from the end of the run, not from a guard."""
        if self.all_warnings:
            self.listen(journal, kept)
        elif self.known is not None:
            self.known = len(self.model.warnings)

    def listen(self, journal: Journal, kept: KeptStates) -> None:
        """Store the steps before the first warning that came since the last look."""
        if self.known is None or len(self.model.warnings) == self.known:
            return
        # before the first step there is nothing to store: the next warning then is the first
        self.known = None if self.store(WARNING, journal, kept) else len(self.model.warnings)

    def begin(self, folder: Path) -> None:
        """Begin or resume the run in its folder: remove what it stored before an earlier failure."""
        drop_last_steps(folder, FAILURE)
        self.known = None if has_last_steps(folder, WARNING) else len(self.model.warnings)

    def store(self, end: str, journal: Journal, kept: KeptStates) -> bool:
        """Hand on the frames of the last steps up to the present step; False if there are none."""
        frames = self._repeated(journal, kept) if self.model.explicit else list(self.frames)
        if frames:
            journal.last_steps(end, [replace(frame, number=k) for k, frame in enumerate(frames)])
        return bool(frames)

    def _repeated(self, journal: Journal, kept: KeptStates) -> list[Frame]:
        """The frames of the last steps, from a model that repeats them; as far as it comes."""
        states = list(kept.states)
        if not states:
            return []
        frames: deque[Frame] = deque(maxlen=self.length)
        until = self.model.state.step
        model, later = self.rebuild(), {state.step: state for state in states}
        states[0].bring_back(model)
        advance, dt = model.bound_integrator().step, states[0].dt
        try:
            while model.state.step < until:
                number = model.state.step
                dt = later[number].dt if number in later else dt
                step = advance(dt)
                if step.status is not StepStatus.accepted or not np.isfinite(model.position).all():
                    break
                frames.append(self._frame(model, step))
                number = model.state.step
                if number in later and not later[number].is_that_of(model):
                    journal.tell("info", f"the repeated steps up to step {number} differ from the original steps")
                    return []
        except Exception:
            pass  # what stopped the run, most likely: the steps before it are there
        return list(frames)

    def _frame(self, model: Model, step: Step) -> Frame:
        return frame_of(model, take_sample(model, 0, float(step.sweeps), self.share(model.state.time)))
