"""Steps that iterate are judged at their end: if a guard objects, the step is rejected and cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contactlab.api import Step, StepStatus
from contactlab.errors import SimulationFailure
from contactlab.implicit.iteration import take_back
from contactlab.run.controlled_step import rejected
from contactlab.run.guards import Guards
from contactlab.run.watches import NoGuards

ENERGY = "the energy of the bodies exceeds the work done on them: stresses change too much in the step"
MOST = 5  # times in a row that a step is cut for a guard: what 1/32 of it does not cure is no matter of its length


class GuardJudge:
    """Judges the steps of a model that can reject them; the last objection of a guard ends the run.

    The energy that a step stores is compared with its work, unless it `skips` the loading path.
    """

    def __init__(self, model: Any, guards: Guards | NoGuards, skips: Callable[[], bool]) -> None:
        self.model, self.guards, self.skips = model, guards, skips
        self.objections, self.controlled = 0, model.integrator.control() is not None

    def begin(self) -> None:
        """Remember the start of a step."""
        self.memory, self.start = self.guards.saved(), self.model.state.snapshot()

    def judged(self, step: Step) -> Step:
        """Return the step; take it back if a guard objects or its error is too large."""
        if step.status is not StepStatus.accepted:
            return step
        try:
            self.guards.check_positions()
            made = not self.skips() and self.guards.step_made_energy()
            reason = ENERGY if made and self.objections < MOST else ""
        except SimulationFailure as failure:
            if self.objections == MOST:
                raise
            reason = failure.reason
        too_wrong = not reason and step.error is not None and step.error > 1.0 and self.controlled
        if not reason and not too_wrong:
            self.objections = 0
            return step
        self.objections += not too_wrong
        take_back(self.model, self.model.state, self.start)
        self.guards.restore(self.memory)
        return (
            rejected(step) if too_wrong else step._replace(status=StepStatus.not_converged, reason=reason, error=None)
        )
