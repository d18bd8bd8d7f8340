"""Lengths of steps: rejection by their errors, the end of the next one, and what to write for shorter ones."""

from __future__ import annotations

import math

from contactlab.api import Step, StepStatus
from contactlab.model.memory import model_memory, restore_model
from contactlab.model.model import Model
from contactlab.run.schedule import SAME_TIME, Schedule

NEARLY = 1e-9  # of a step, or of the time between frames: differences below it are round-off


def rejected(step: Step) -> Step:
    """The step, not accepted: its error exceeds the tolerance."""
    reason = f"its error is {step.error:.3g} times its tolerance"
    return step._replace(status=StepStatus.not_converged, reason=reason)


class ControlJudge:
    """Judges the steps of an explicit model, and restores it if the error of a step exceeds its tolerance."""

    def __init__(self, model: Model) -> None:
        self.model = model

    def begin(self) -> None:
        """Remember the start of a step."""
        self.start = {name: array.copy() for name, array in model_memory(self.model).items()}

    def judged(self, step: Step) -> Step:
        """Return the step; restore the state if its error is too large."""
        if step.error is None or step.error <= 1.0:
            return step
        restore_model(self.model, self.start)
        return rejected(step)


def next_stop(schedule: Schedule, end: float) -> float:
    """The time [s] of the next frame, or `end` if that is nearer or as good as the same."""
    frame = schedule.next_frame
    while frame * (1.0 - SAME_TIME) <= schedule.state.time:  # as frames are found to be due
        frame += schedule.frame_every
    return frame if frame < end - NEARLY * schedule.frame_every else end


def within(dt: float, rest: float) -> float:
    """A step of at most dt that meets the end of the time `rest`, without a sliver before."""
    number = max(1, math.ceil(rest / dt * (1.0 - NEARLY)))
    return rest / number if number <= 2 else dt


def better_steps(key: str, now: float, times: float) -> str:
    """In words, `now` of the key that fixes steps (their number, or their length) for steps so many times as short."""
    if key == "time.step":
        return f"{now / times:.2g} or less"
    unit = 10.0 ** max(math.floor(math.log10(now * times)) - 1.0, 0.0)
    return f"{int(unit * math.ceil(now * times / unit - 1e-9))} or more"
