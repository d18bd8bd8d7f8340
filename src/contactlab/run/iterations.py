"""States after Newton's iterations: whether a run records them, and how many."""

from __future__ import annotations

import math

from contactlab.api import Layout
from contactlab.model.implicit_model import ImplicitModel
from contactlab.model.model import Model
from contactlab.results.iterate_sampler import IterateSampler
from contactlab.results.record_plan import IteratePlan, iterate_bytes
from contactlab.run.run import Run
from contactlab.scene.keys import Record

IN_A_STEP = 6  # iterations of a step, for an estimate of what their states take


def iterate_plan(model: Model, layout: Layout) -> IteratePlan | None:
    """Return which iterations are kept; None if there are none, or no room for any."""
    return IteratePlan.of(layout, model.shown_conditions) if isinstance(model, ImplicitModel) else None


def iterates_on_disk(model: Model, plan: IteratePlan, layout: Layout, steps: int) -> float:
    """About what the states of a run of so many steps take [bytes]."""
    assert isinstance(model, ImplicitModel)
    return min(plan.rows, IN_A_STEP * steps) * float(iterate_bytes(layout, model.shown_conditions))


def record_iterates(run: Run, plan: IteratePlan, record: Record) -> None:
    """Copy states after iterations from here on."""
    assert isinstance(run.model, ImplicitModel)
    steps = record.from_ or 1, record.to or math.inf
    run.iterates = IterateSampler(run.model, plan, *steps, done=len(run.journal.iterations))
    run.model.listening = run.iterates.seen
