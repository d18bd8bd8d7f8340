"""Scalars of every step: sampled into a buffer, handed on in blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import FactoredRows, Floats, FrictionBound, Step
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.compiled.friction import STICKS
from contactlab.api.state import WORK
from contactlab.kernels.step_scalars import ACTIVE, CONTACT, MODEL, STICKING, model_scalars, step_scalars
from contactlab.model.model import Model
from contactlab.results.step_columns import COUNTS

SAVED = "recorded.states"
COSTS = slice(COUNTS.index("cost.elements"), len(COUNTS))
CLOCK = 2.0**-23  # s: finer digits of a cost are noise, and noise takes room in a file
BLOCK = 256  # steps between hand-overs; long enough that a hand-over costs nothing per step

Sample = Callable[[Step, float], None]


class StepSampler:
    """Samples a model after each step. `sample` is what the loop calls; `flush` hands on what is left.

    `take` gets blocks (b, columns) with b <= BLOCK; it must not keep the array.
    """

    def __init__(self, model: Model, columns: int, take: Callable[[Floats], None]) -> None:
        self.rows: Floats = np.zeros((BLOCK, columns))
        pairs = model.contact.pairs if model.contact is not None else ()
        self.states = np.zeros((2, pairs[-1].own.stop if pairs else 0), np.int32)
        self.count = 0
        self.take = take
        sample = _sample_of(self, model)
        self.sample = sample if model.split is None else _with_split(self, sample, model.split.work)

    def saved(self) -> dict[str, Floats]:
        """The states of the conditions at the last step, by a name."""
        return {SAVED: self.states[0].astype(np.float64)}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to saved states."""
        self.states[0] = memory[SAVED]

    def flush(self) -> None:
        """Hand on the rows since the last time."""
        if self.count:
            rows, self.count = self.rows[: self.count], 0
            rows[:, COSTS] = np.rint(rows[:, COSTS] / CLOCK) * CLOCK
            self.take(rows)


def _with_split(sampler: StepSampler, sample: Sample, work: Floats) -> Sample:
    """The same with the parts of the contact `work` in the last columns."""
    rows = sampler.rows[:, -len(work) :]

    def both(step: Step, dt: float) -> None:
        rows[sampler.count] = work
        sample(step, dt)

    return both


def _sample_of(sampler: StepSampler, model: Model) -> Sample:
    if model.contact is None:
        return _without_contact(sampler, model)
    return _with_rows(sampler, model) if hasattr(model.contact, "rows") else _with_conditions(sampler, model)


def _without_contact(sampler: StepSampler, model: Model) -> Sample:
    bound, works = _bound_model(sampler.rows, model), len(WORK)
    address, elements = bound.address, model.seconds

    def sample(step: Step, dt: float) -> None:
        nonlocal elements
        row, spent, elements = sampler.count, model.seconds - elements, model.seconds
        model_scalars(row, address, dt, step.sweeps, step.iterations, step.residual, spent, 0.0, works)
        sampler.count = row + 1
        if row + 1 == BLOCK:
            sampler.flush()

    sample.bound = bound  # type: ignore[attr-defined]  # keeps the addresses good
    return sample


def _with_rows(sampler: StepSampler, model: Model) -> Sample:
    contact = model.contact
    assert contact is not None
    bound, works = _bound_model(sampler.rows, model), len(WORK)
    address, elements, solving = bound.address, model.seconds, contact.seconds
    rows, factored = contact.rows, contact.factored
    bound_rows = _bound_rows(sampler, model)
    rows_address = bound_rows.address

    def sample(step: Step, dt: float) -> None:
        nonlocal elements, solving, rows, factored, bound_rows, rows_address
        if contact.rows is not rows or contact.factored is not factored:  # they were reallocated with more room
            rows, factored = contact.rows, contact.factored
            bound_rows = _bound_rows(sampler, model)
            rows_address = bound_rows.address
        row, of_elements, of_contact = sampler.count, model.seconds - elements, contact.seconds - solving
        elements, solving = model.seconds, contact.seconds
        step_scalars(
            row, address, rows_address, dt, step.sweeps, step.iterations, step.residual, of_elements, of_contact, works,
            rows.count, 0 if factored is None else factored.count,
        )  # fmt: skip
        sampler.count = row + 1
        if row + 1 == BLOCK:
            sampler.flush()

    sample.bound = bound  # type: ignore[attr-defined]  # keeps the addresses good
    return sample


def _with_conditions(sampler: StepSampler, model: Model) -> Sample:
    """Implicit steps take thousands of times as long as a sample: plain NumPy serves."""
    contact: Any = model.contact
    bound, works = _bound_model(sampler.rows, model), len(WORK)
    elements, solving = model.seconds, contact.seconds

    def sample(step: Step, dt: float) -> None:
        nonlocal elements, solving
        row, of_elements, of_contact = sampler.count, model.seconds - elements, contact.seconds - solving
        elements, solving = model.seconds, contact.seconds
        counts = (step.sweeps, step.iterations, step.residual)
        at = model_scalars(row, bound.address, dt, *counts, of_elements, of_contact, works)
        before, now = sampler.states
        for pair in contact.pairs:
            own = pair.own
            now[own], penetration = _conditions_of(contact.conditions, own, pair.lagged)
            active, sticking = np.count_nonzero(now[own]), np.count_nonzero(now[own] == STICKING)
            sampler.rows[row, at : at + 4] = active, sticking, penetration, np.count_nonzero(now[own] != before[own])
            at += 4
        before[:] = now
        sampler.count = row + 1
        if row + 1 == BLOCK:
            sampler.flush()

    return sample


def _conditions_of(c: Any, own: slice, lagged: float) -> tuple[np.ndarray, float]:
    """Find the states of the conditions `own` of one pair, and its penetration; its friction may be `lagged`."""
    pressed = c.force[0, own]
    pulled = np.abs(c.force[-1, own]) if len(c.force) > 1 else np.zeros_like(pressed)
    active = (pressed > 0.0) | (pulled > 0.0)
    sticking = np.zeros_like(active)
    if c.bound.shape[1]:
        bound, _ = FrictionBound(*c.bound[:, own]).limits(pressed, c.measure[own])
        sticking = active & (pulled < np.minimum(STICKS * bound, bound - lagged * pressed.max(initial=0.0)))
    deepest = np.where(c.present[own], -c.gap[own], 0.0).max(initial=0.0)
    return np.where(sticking, STICKING, active * ACTIVE), float(deepest)


def _bound_model(buffer: Floats, model: Model) -> BoundArrays:
    # where each support begins, and the degrees of freedom of all of them one after another
    parts = [support.dof for support in model.loading.supports]
    starts = np.cumsum([0, *(len(part) for part in parts)]).astype(np.int64)
    dofs = np.concatenate([np.zeros(0, np.int64), *parts]).astype(np.int64)
    # where the fields begin in the state's buffer, -1 for those that do not exist
    state = model.state
    begins = [(state[n].ctypes.data - state.buffer.ctypes.data) // 8 if n in state else -1 for n in _FIELDS]
    return BoundArrays(MODEL, buffer, model.state.buffer, model.mass, np.array(begins, np.int64), starts, dofs)


def _bound_rows(sampler: StepSampler, model: Model) -> BoundArrays:
    contact = model.contact
    assert contact is not None
    pairs, r, factored = contact.pairs, contact.rows, contact.factored or FactoredRows.allocate(0, 0)
    starts = np.array([*(pair.first_slot for pair in pairs), pairs[-1].own.stop], np.int32)
    of_rows = (r.start, r.node, r.normal_weight, r.slot, r.measure, r.offset, r.bound, factored.slot, factored.left)
    return BoundArrays(CONTACT, sampler.rows, model.position, contact.multipliers, starts, *of_rows, *sampler.states)


_FIELDS = ("clock", "velocity", "work", "reaction")
