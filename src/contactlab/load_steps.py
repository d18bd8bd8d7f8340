"""Step lengths of implicit runs: as the scene wishes, shorter where Newton's method fails, and back again."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from contactlab.api import Floats, Step, StepStatus
from contactlab.errors import SimulationFailure
from contactlab.schedule import Schedule

CUT = 0.5  # of the step that failed
GROW = 2.0  # after a step that converged easily
EASY = 8  # iterations of a step after which a longer one is tried
SHORTEST = 2.0**-12  # of the wished step: below it the run is given up
NEARLY = 1e-9  # of a step: differences of time below it are round-off


class LoadSchedule(Schedule):
    """Equal steps as long as they converge. A failed step is cut and tried again from the same state."""

    def _first_step(self) -> float:
        total = self.pace.end or self.pace.ramp
        self.wished = float(self.fixed) if self.fixed is not None else total / self.model.integrator.wished_steps()
        self.whole = self.wished
        return self.wished

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """What to call after each accepted step, with the step and its length."""
        return (self._took,)

    def _took(self, step: Step, dt: float) -> None:
        """Follow an accepted step: longer again where it was easy, and never past the end."""
        if step.iterations <= EASY:
            self.whole = min(self.wished, GROW * self.whole)
        self._fit()

    def cut(self, step: Step) -> str:
        """Shorten a step that failed; what was done, for the record. Raises SimulationFailure below the shortest."""
        tried = self.dt
        self.whole = CUT * tried
        if self.whole < SHORTEST * self.wished:
            raise SimulationFailure(
                "not-converged",
                f"after step {self.state.step}, at time {self.state.time:.6g}: a step of {tried:.3g} failed, "
                f"1/{self.wished / tried:.0f} of the wished one: {step.reason}; {StepStatus.gave_up.value}",
            )
        self._fit()
        return f"a step of {tried:.6g} from time {self.state.time:.6g} was taken back after {step.iterations} iterations: " + (
            f"{step.reason}; {self.dt:.6g} is tried"
        )

    def follow(self) -> None:
        """Nothing limits an implicit step but its convergence."""

    def _fit(self) -> None:
        """Let the last step of the run end where the run does, without a sliver before it."""
        rest = self.end - self.state.time
        self.dt = self.whole
        if rest <= 0.0:
            return
        number = max(1, int(np.ceil(rest / self.whole * (1.0 - NEARLY))))
        if number <= 2:
            self.dt = rest / number

    def _over(self, limit: float) -> bool:
        if self.state.time >= limit - NEARLY * self.wished:
            return True
        return super()._over(np.inf) if self.pace.settle else False

    def memory(self) -> dict[str, Floats]:
        """Everything that changes while the run goes on."""
        return super().memory() | {"schedule.load": np.array([self.wished, self.whole])}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Back to where `memory` was taken."""
        super().restore(memory)
        self.wished, self.whole = memory["schedule.load"].tolist()
