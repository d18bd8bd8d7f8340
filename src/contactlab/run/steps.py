"""The step loop."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from contactlab.api import Step, StepStatus

if TYPE_CHECKING:
    from contactlab.model.bound_integrator import BoundIntegrator
    from contactlab.run.run import Run


def steps(run: Run, integrator: BoundIntegrator) -> Iterator[Step]:
    """Accepted steps until the run is over, each counted, guarded and sampled; failed ones are tried again, shorter."""
    schedule, guards, counts, every_step = run.schedule, run.guards, run.counts, run.every_step
    advance = run.guarded(integrator)
    while not schedule.done():
        step = advance(schedule.dt)
        if step.trace:
            run.iterated(step)
        if step.status is not StepStatus.accepted:
            run.taken_back(step)
            continue
        counts.steps += 1
        counts.iterations += step.iterations
        counts.sweeps += step.sweeps
        guards.after_step(step)
        for sample in every_step:
            sample(step, schedule.dt)
        yield step
