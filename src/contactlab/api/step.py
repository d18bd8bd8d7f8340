"""A step: its final status, and the length of the next step from its error."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from contactlab.api.arrays import Floats


class StepStatus(Enum):
    """Final status of a step; the string advises what to try."""

    accepted = ""
    not_converged = "the iteration did not converge; a shorter step is tried next"
    gave_up = "the shortest step failed; try more integrator.steps or integrator.iterations, or another enforcement"


class Iteration(NamedTuple):
    """A recorded iteration of an implicit step.

    force     largest unbalanced nodal force over the largest force of the model
    contact   largest residual of the contact conditions, as the integrator measures it: in segment lengths, or over the
              largest force
    active    closed constraints; sticking: constraints in stick; changed: constraints whose contact state changed
    length    fraction of the computed correction that was taken
    note      any departure from a plain iteration, with its reason
    statuses  a digit per contact constraint: 0 open, 1 stick, 2 slip; empty if unknown
    """

    force: float
    contact: float
    active: int
    sticking: int
    changed: int
    length: float
    note: str = ""
    statuses: str = ""


class Step(NamedTuple):
    """Result of an attempted step: its status, work and reactions, and its iterations.

    work        (7,) energy balance at its end, see `contactlab.api.WORK` [mJ]
    reaction    (N, 2) [N] forces of the supports on prescribed degrees of freedom, 0 elsewhere
    status      its acceptance; if it is not accepted, `reason` gives the cause and no other field is needed
    iterations  number of Newton iterations; `trace` has each of them
    sweeps      Gauss-Seidel iterations of the contact solve; `residual` is the residual at its end
    error       estimate of the error made in this step over its tolerance: 1 is just allowed; None without an estimate
    longest     longest length [s] of the next step, or of this step if it is to be repeated; None: the schedule's own.
                Only for implicit steps; a step repeated with it has not failed

    `work` and `reaction` are new arrays, or the state's own fields of these names brought up to date in place.
    """

    work: Floats | None = None
    reaction: Floats | None = None
    status: StepStatus = StepStatus.accepted
    iterations: int = 0
    sweeps: int = 0
    residual: float = 0.0
    reason: str = ""
    trace: tuple[Iteration, ...] = ()
    error: float | None = None
    longest: float | None = None


@dataclass(frozen=True)
class StepControl:
    """Choose the length of the next step from the errors of this step and the last one, a PI controller.

    A step whose error exceeds its tolerance is repeated from the same state with a shorter length.

    order         power of the step length that the estimated error falls with; 3 for the error in one step of a
                  second-order scheme
    safety        fraction of the length that would just pass the tolerance
    integral      weight of the error of this step; `proportional` weight of the change of errors: 0.7 and 0.4 keep
                  steps smooth (Hairer & Wanner, Solving Ordinary Differential Equations II, IV.2)
    shrink, grow  limits of the ratio of a step to the previous step
    """

    order: int
    safety: float = 0.9
    integral: float = 0.7
    proportional: float = 0.4
    shrink: float = 0.2
    grow: float = 2.0

    def ratio(self, error: float, before: float) -> float:
        """Return the next step length over the present one; errors over their tolerances, `before` of the last step.

        `before` is 1 in the first step. A step whose error exceeds 1 was rejected, and the ratio is below 1.
        """
        error = max(error, 1e-10)
        if error > 1.0:
            return max(self.shrink, float(self.safety * error ** (-1.0 / self.order)))
        before = max(before, 1e-10)
        ratio: float = self.safety * error ** (-self.integral / self.order) * before ** (self.proportional / self.order)
        return min(self.grow, max(self.shrink, ratio))
