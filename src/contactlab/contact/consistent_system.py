"""All contact pairs of a model, whose forces act along the derivatives of the gaps (theory/contact-energy.md).

Rows are tried in this order: before T is inverted, by overlap ends (`ModelGradients`) or, if closest points are
joined, by columns (`ConstantColumns`); then written out (`contactlab.contact.gradients`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from contactlab.api import ExplicitEnforcement, FactoredGradients, FactoredRows, Floats, Ints, Rows, State
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.contact.explicit_system import GROW, Columns, ContactSystem, Reduced
from contactlab.contact.gradients import PairGradients
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.contact.start_gaps import FacetOverlap
from contactlab.kernels.contact import factored_gradients
from contactlab.kernels.contact.factored_gradients import EndsTable
from contactlab.kernels.contact.gap_gradients import allow_constant_motion, allow_motion, largest_sideways

ROUND = 1e-9  # segment lengths: an offset this far across a normal turns it by round-off


class ConsistentContactSystem(ContactSystem):
    """`ContactSystem` whose rows are the derivatives of the gaps at the start of the step."""

    consistent: ClassVar[bool] = True

    def __init__(self, pairs: tuple[ContactPair, ...], enforcement: ExplicitEnforcement, state: State) -> None:
        super().__init__(pairs, enforcement, state)
        # finished constraints have weights that are the derivatives of their gaps already
        self.gradients = {n: PairGradients(pair) for n, pair in enumerate(pairs) if isinstance(pair, OperatorPair)}
        for pair in pairs:
            if isinstance(pair, OperatorPair):
                pair.coupling.let_go()
        self.velocity = state["velocity"]

    def calls_per_step(self) -> Counter[str]:
        """Count constraints once; slips use the gradients, which need no normals at the start of the step."""
        calls = super().calls_per_step()
        del calls["contact normals"]
        return Counter({call: min(count, len(self.passes)) for call, count in calls.items()})

    def _reductions(self, pairs: tuple[ContactPair, ...]) -> tuple[Reduced, ...]:
        """Return rows by overlap ends, and rows by columns if closest points are joined."""
        if not self.enforcement.factored:
            return ()
        found: list[Reduced] = []
        if len(known := with_ends(pairs)) == len(pairs):
            found.append(ModelGradients(known, self.state))
        if len(closest := joined(self.passes)) == len(self.passes):
            found.append(ConstantColumns(closest, self.state))
        return tuple(found)

    def _update(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> None:
        for pair, memory in zip(self.passes, self.memories, strict=True):
            pair.update(current, memory)

    def _append(self, number: int, entries: int, margin: float, current: Floats, predicted: Floats) -> int:
        rows, first, pair = self.rows, self.rows.count, self.passes[number]
        if number in self.gradients:
            gradients = self.gradients[number]
            entries = gradients.append_rows(rows, entries, margin, self.multipliers, self.memories[number])
        else:
            entries = super()._append(number, entries, margin, current, predicted)
        if entries >= 0:
            self._advance(pair, first, current, predicted)
            push_facets(pair, rows, self.state, first)
        return entries

    def _advance(self, pair: ContactPair, first: int, current: Floats, predicted: Floats) -> None:
        """Set what the rows of a pair, from `first` on, have to hold at the end of the step."""
        # pushing out an initial overlap adds energy on purpose
        strict, rows = not pair.pushes_overlaps_out, self.rows
        allow_motion(first, rows.count, rows, current, predicted, self.velocity, self.state.last_dt, strict)


class ModelGradients(Reduced):
    """The factored rows of a model's pairs, rebuilt in every step."""

    rows: FactoredGradients

    def __init__(self, pairs: Sequence[OperatorPair], state: State) -> None:
        self.state = state
        self.number = np.full(len(state["displacement"]), -1, np.int32)
        self.touched = sum(len(pair.slave.nodes) + len(pair.master.nodes) for pair in pairs)
        self.ends = [PairEnds(pair, self.number, self.touched) for pair in pairs]
        self.memories = [pair.memory_in(state) for pair in pairs]
        self.rows = self._room(8 * sum(pair.slots for pair in pairs))

    def _room(self, entries: int) -> FactoredGradients:
        self.number[:] = -1
        return FactoredGradients.allocate(sum(ends.pair.slots for ends in self.ends), entries, self.touched)

    def assemble(self, current: Floats, predicted: Floats) -> bool:
        """Make the rows of all pairs as last updated; False if an algorithm does not give its overlap ends."""
        self.rows.factors.count = 0
        for ends, memory in zip(self.ends, self.memories, strict=True):
            if not ends.found(memory):
                return False
        while not self._written():
            self.rows = self._room(int(GROW * len(self.rows.factors.node)) + 64)
        rows, state = self.rows, self.state
        factored_gradients.allow_factored_motion(
            self.rows.factors.count, rows, current, predicted, state["velocity"], state.last_dt
        )
        for ends in self.ends:
            push_facets(ends.pair, self.rows.factors, state, offset=rows.offset)
        return True

    def _written(self) -> bool:
        count = 0
        for ends in self.ends:
            pair = ends.pair
            count = factored_gradients.write_gradients(
                pair.address, ends.bound.address, pair.count, pair.first_slot, count, self.rows
            )
            if count < 0:
                return False
        self.rows.factors.count = count
        return True


class PairEnds:
    """Overlap ends of a pair's integration segments on both sides, and scratch arrays.

    number  (N,) numbers of global nodes, shared by all pairs of a model
    nodes   largest number of nodes that the constraints touch
    """

    def __init__(self, pair: OperatorPair, number: Ints, nodes: int) -> None:
        self.pair, self.number, self.nodes = pair, number, nodes
        self._bind(0)

    def _bind(self, pieces: int) -> None:
        m, k, n = len(self.pair.slave.nodes), self.pair.slots, self.nodes
        angle, place, seen, first, last = (np.zeros(size, np.int32) for size in (m, n, n, k, k))
        self.feet = np.zeros((pieces, 4))
        rate, lever = (np.zeros((pieces, 2, 2)) for _ in range(2))
        self.bound = BoundArrays(
            EndsTable, self.feet, self.number, angle, place, seen, first, last, np.zeros((pieces, 6), np.int32),
            rate, lever, np.zeros((pieces, 2)),
        )  # fmt: skip

    def found(self, memory: Floats) -> bool:
        """Fill `feet` for the integration segments of the last update; False if the algorithm does not give them."""
        pair = self.pair
        if pair.count > len(self.feet):
            self._bind(len(pair.pieces.slave))
        # of a mortar by formulas the ends of its pieces; False if its normals were turned at ends or vertices
        return not pair.lumped and pair.algorithm.feet(pair.seen(memory), pair.pieces, pair.count, self.feet)


def with_ends(pairs: Sequence[ContactPair]) -> list[OperatorPair]:
    """Return the pairs whose rows follow from overlap ends: straight edges, no friction, no ramped overlaps."""
    return [
        pair
        for pair in pairs
        if isinstance(pair, OperatorPair)
        and all(side.edges.shape[1] == 2 for side in (pair.slave, pair.master))
        and pair.friction is None
        and not pair.pushes_overlaps_out
    ]


class ConstantColumns(Columns):
    """Rows along normals that are exact derivatives of the gaps, as closest points are joined."""

    pairs: Sequence[OperatorPair]
    offset: Floats

    def __init__(self, pairs: Sequence[OperatorPair], state: State) -> None:
        super().__init__(pairs)
        self.state, self.offset = state, np.zeros(len(self.rows.gap))

    def assemble(self, current: Floats, predicted: Floats) -> bool:
        """Make the rows; False if joined points are offset across the normal."""
        if any(largest_sideways(pair.address) > ROUND for pair in self.pairs):
            return False
        super().assemble(current, predicted)
        rows, velocity, dt = self.rows, self.state["velocity"], self.state.last_dt
        allow_constant_motion(rows.count, rows, current, predicted, velocity, dt, self.offset)
        for pair in self.pairs:
            push_facets(pair, rows, self.state, offset=self.offset)
        return True


def joined(pairs: Sequence[ContactPair]) -> list[OperatorPair]:
    """Return the pairs whose constraints join closest points, and can be given by columns."""
    return [
        pair
        for pair in pairs
        if isinstance(pair, OperatorPair)
        and pair.algorithm.closest_points
        and pair.friction is None
        and not pair.pushes_overlaps_out
    ]


def push_facets(
    pair: ContactPair, rows: Rows | FactoredRows, state: State, first: int = 0, offset: Floats | None = None
) -> None:
    """Push weak initial overlaps out as their share grows: rows hold u + d, two steps.

    Rows from `first` on may belong to the pair; `offset` (k,) [mm] is added to the gaps of the rows at the end.
    """
    if not isinstance(facets := pair.start_gaps, FacetOverlap):
        return
    time, dt = state.time, state.last_dt
    if (pushed := facets.pushed(max(0.0, time - dt), time + dt)) is None:
        return
    slot = rows.slot[first : rows.count] - pair.first_slot
    own = first + np.flatnonzero((slot >= 0) & (slot < len(pushed)))
    more = pushed[slot[own - first]]
    rows.gap[own] += more
    if offset is not None:
        offset[own] -= more
