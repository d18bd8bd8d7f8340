"""The contact record: what each slave node feels in every step, sampled into a buffer and handed on in blocks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats, Layout, PointContact, Step
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.contact_steps import contact_record
from contactlab.contact.cornered_pair import CorneredPair
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.contact.sliding import VaryingSliding
from contactlab.kernels.contact.record import RecordColumns, RecordScratch, RecordTable, record_pair
from contactlab.model.model import Model
from contactlab.results.contact_nodes import facing_segments, node_values
from contactlab.results.record_plan import Window
from contactlab.results.slips import slips_of

BLOCK = 512  # rows between hand-overs

Block = Mapping[str, np.ndarray]
"""Rows of each contact by its name, see `contactlab.api.contact_steps.contact_record`."""


class ContactSampler:
    """Samples the contacts of a model after the steps of a window. `sample` is what the loop calls.

    `take` gets a block of at most BLOCK rows of every contact, and may keep it.
    """

    def __init__(self, model: Model, layout: Layout, window: Window, take: Callable[[Block], None]) -> None:
        assert model.contact is not None
        self.window, self.take, self.count = window, take, 0
        self.types = {contact.name: contact_record(contact) for contact in layout.contacts}
        self.when: Floats = np.zeros((2, BLOCK))
        self.arrays = {name: _columns(kind) for name, kind in self.types.items()}
        pairs = [(pair, self.arrays[pair.name]) for pair in model.contact.pairs]
        self.sample = self._sample_of(model, [_recorder_of(model, pair, columns) for pair, columns in pairs])

    def flush(self) -> None:
        """Hand on the rows since the last time."""
        if not self.count:
            return
        block, count, self.count = {}, self.count, 0
        for name, kind in self.types.items():
            rows = np.empty(count, kind)
            rows["step"], rows["time"] = self.when[:, :count]
            for field, values in self.arrays[name].items():
                rows[field] = values[:count]
            block[name] = rows
        self.take(block)

    def _sample_of(self, model: Model, recorders: list[Callable[[int], None]]) -> Callable[[Step, float], None]:
        clock, window, (numbers, times) = model.state["clock"], self.window, self.when
        due, every, last = window.following(model.state.step), window.every, window.last

        def sample(step: Step, dt: float) -> None:
            nonlocal due
            number = clock[1]
            if number < due:
                return
            row = self.count
            for record in recorders:
                record(row)
            times[row], numbers[row] = clock[0], number
            due = number + every if number + every <= last else math.inf
            self.count = row + 1
            if row + 1 == BLOCK:
                self.flush()

        return sample


def _columns(kind: np.dtype[Any]) -> dict[str, np.ndarray]:
    """An array (BLOCK, m) for each quantity of a row."""
    assert kind.names is not None
    return {name: np.zeros((BLOCK, *kind[name].shape), kind[name].base) for name in kind.names[2:]}


def _recorder_of(model: Model, pair: ContactPair, columns: dict[str, np.ndarray]) -> Callable[[int], None]:
    """Return a function that fills a row of one contact from the model after a step."""
    if not isinstance(pair, OperatorPair) or pair.algorithm.points_press:
        return _by_numpy(model, pair, columns)
    compiled = _compiled(model, pair, columns)
    if not (pair.smooth or isinstance(pair, CorneredPair) or isinstance(pair.method, PointContact)):
        return compiled

    def record(row: int) -> None:
        compiled(row)
        if pair.smooth or pair.holds_corners:
            _fill(columns, row, node_values(pair, pair.snapshot(model.state, model.position)))

    return record


def _fill(columns: dict[str, np.ndarray], row: int, values: dict[str, np.ndarray]) -> None:
    for name in values.keys() & columns.keys():
        columns[name][row] = values[name]


def _compiled(model: Model, pair: OperatorPair, columns: dict[str, np.ndarray]) -> Callable[[int], None]:
    contact: Any = model.contact
    slid, compliance = np.zeros(pair.slots), np.zeros_like(model.reference)
    bound = _bound(model, pair, columns, slid, compliance)
    address = bound.address
    # what share of the gaps of the start does not count
    uncounted: Callable[[], float] = (lambda: 0.0) if pair.start_gaps is None else pair.start_gaps.uncounted
    own = pair.own

    def record(row: int) -> None:
        rows = contact.rows
        if pair.friction is not None:
            np.copyto(compliance, contact.compliance)
        record_pair(row, pair.address, address, rows, rows.count, uncounted())

    def record_implicit(row: int) -> None:
        if pair.friction is not None:
            slid[:] = contact.conditions.slip[own]
        record_pair(row, pair.address, address, contact.rows, -1, uncounted())

    chosen = record_implicit if hasattr(contact, "conditions") else record
    chosen.bound = bound  # type: ignore[attr-defined]  # keeps the addresses good
    return chosen


def _bound(
    model: Model, pair: OperatorPair, columns: dict[str, np.ndarray], slid: Floats, compliance: Floats
) -> BoundArrays:
    contact: Any = model.contact
    k, m, start = pair.slots, len(pair.slave.nodes), pair.start_gaps
    law = np.zeros((3, 0))
    if pair.sliding is not None:
        law = (
            pair.sliding.kept if isinstance(pair.sliding, VaryingSliding) else pair.sliding.of(slice(None)).repeat(k, 1)
        )
    distance = np.zeros(k)
    if start is not None:
        distance[:] = start.value
    none = np.zeros((0, m), np.float32)
    force = model.state["contact_force"] if "contact_force" in model.state else np.zeros((0, 2))
    sides = np.zeros((m, 2)), np.zeros((len(pair.master.nodes), 2))
    return BoundArrays(
        RecordTable, model.position, force, contact.multipliers, compliance, law,
        np.array([pair.first_slot], np.int32), pair.master.node_segments, *pair.between, distance,
        RecordScratch(*sides, np.zeros((k, 2)), np.zeros((k, 2)), np.zeros((2, k)), slid),
        RecordColumns(*(columns.get(name, none) for name in RecordColumns._fields)),
    )  # fmt: skip


def _by_numpy(model: Model, pair: ContactPair, columns: dict[str, np.ndarray]) -> Callable[[int], None]:
    """For pairs whose conditions come finished: they are made in Python, too."""
    contact: Any = model.contact
    own = pair.own

    def record(row: int) -> None:
        seen = pair.snapshot(model.state, model.position)
        _fill(columns, row, node_values(pair, seen))
        columns["segment"][row] = facing_segments(pair)
        if "slip" in columns:
            implicit = hasattr(contact, "conditions")
            slips = contact.conditions.slip[own] if implicit else slips_of(model)[own]
            columns["slip"][row] = pair.slips_at_nodes(slips, seen.gaps)

    return record
