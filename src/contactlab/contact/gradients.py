"""Rows of consistent forces, gaps differentiated by all that they depend on: written out, or before T is inverted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contactlab.api import (
    ExplicitEnforcement,
    FactoredGradients,
    FactoredRows,
    Floats,
    GapGradients,
    Ints,
    Rows,
    Solve,
    State,
)
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.contact.differences import DerivativesOfPieces
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.contact.start_gaps import FacetOverlap
from contactlab.kernels.contact import factored_gradients, gap_gradients
from contactlab.kernels.contact.factored_gradients import EndsTable
from contactlab.kernels.contact.pair import FAR

GROW = 1.5
NORMALS = 6  # room for derivatives of normals, for each multiplier


class PairGradients:
    """The derivatives of a pair's integration segments and normals, and the rows that follow."""

    def __init__(self, pair: OperatorPair) -> None:
        self.pair = pair
        self.derivatives: DerivativesOfPieces | None = None
        self.own, self.general = self._room(0, pair.algorithm.gradient_nodes), self._room(0, 1)
        self._bind(self.own)

    def _room(self, entries: int, nodes: int) -> GapGradients:
        return GapGradients.allocate(entries, self.pair.widths[1], nodes, NORMALS * self.pair.slots)

    def _bind(self, g: GapGradients) -> None:
        self.bound_of, self.bound = g, BoundArrays(GapGradients, g)

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, memory: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`, gaps as they are now, no slips yet.

        Returns the next free entry, or -1 if `out` is too small.
        """
        pair, found = self.pair, self.found(memory)
        if found is not self.bound_of:
            self._bind(found)
        taken = pair.corners is not None and pair.corners.moved
        first, margin = out.count, FAR if pair.everywhere or taken else min(margin, FAR)
        used = pair.count, found.count, found.normal_count
        count, end = gap_gradients.write_rows(
            pair.address, self.bound.address, used, margin, multipliers, pair.first_slot,
            (first, entries), out.packed.address,
        )  # fmt: skip
        if count < 0:
            return -1
        if len(out.slip):
            if pair.sliding is None:
                out.bound[:, first:count] = 0.0
            else:
                pair.write_bounds(out, first, count)
        out.count = count
        return pair.corners.take_rows(out, first, int(end)) if pair.corners is not None else int(end)

    def found(self, memory: Floats) -> GapGradients:
        """Return derivatives of the last update, given by the algorithm or built from its derivatives."""
        pair = self.pair
        if not pair.algorithm.gradient_nodes:
            return self._from_derivatives(memory)
        if pair.count > len(self.own.node):
            self.own = self._room(len(pair.pieces.slave), pair.algorithm.gradient_nodes)
        given = pair.algorithm.gradients(
            pair.seen(memory), pair.pieces, pair.count, pair.coupling.owner, pair.separation, self.own
        )
        return self.own if given else self._from_derivatives(memory)

    def _from_derivatives(self, memory: Floats) -> GapGradients:
        pair = self.pair
        if self.derivatives is None:
            self.derivatives = DerivativesOfPieces(pair)
        found = self.derivatives.of(memory)
        if len(self.general.node) < len(found.moved) or self.general.normal_of is not found.normal_of:
            self.general = self._room(len(found.moved), 1)
            self.general.normal_of, self.general.normal_moved = found.normal_of, found.normal_moved
            self.general.dnormal = found.dnormal
        self.general.count = gap_gradients.from_derivatives(
            found.count,
            (found.slave, found.multiplier, found.master, found.moved, found.dD, found.dM, found.dT),
            pair.coupling.owner, tuple(pair.at), pair.separation,
            (self.general.multiplier, self.general.node, self.general.value),
        )  # fmt: skip
        self.general.normal_count = found.normal_count
        return self.general


# --- before T is inverted ---------------------------------------------------------------------------------------------


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
        return pair.algorithm.feet(pair.seen(memory), pair.pieces, pair.count, self.feet)


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


class ModelGradients:
    """The factored rows of a model's pairs, rebuilt in every step; `contactlab.contact.explicit_system.Reduced`."""

    def __init__(self, pairs: Sequence[OperatorPair], enforcement: ExplicitEnforcement, state: State) -> None:
        self.enforcement, self.state = enforcement, state
        self.number = np.full(len(state["displacement"]), -1, np.int32)
        self.touched = sum(len(pair.slave.nodes) + len(pair.master.nodes) for pair in pairs)
        self.ends = [PairEnds(pair, self.number, self.touched) for pair in pairs]
        self.memories = [pair.memory_in(state) for pair in pairs]
        self.rows = self._room(8 * sum(pair.slots for pair in pairs))

    @property
    def factors(self) -> FactoredRows:
        """The chains of T, and the gaps."""
        return self.rows.factors

    def _room(self, entries: int) -> FactoredGradients:
        self.number[:] = -1
        return FactoredGradients.allocate(sum(ends.pair.slots for ends in self.ends), entries, self.touched)

    def assemble(self, current: Floats, predicted: Floats) -> bool:
        """Make the rows of all pairs as last updated; False if an algorithm does not give its overlap ends."""
        self.factors.count = 0
        for ends, memory in zip(self.ends, self.memories, strict=True):
            if not ends.found(memory):
                return False
        while not self._written():
            self.rows = self._room(int(GROW * len(self.factors.node)) + 64)
        rows, state = self.rows, self.state
        factored_gradients.allow_factored_motion(
            self.factors.count, rows.packed.address, current, predicted, state["velocity"], state.last_dt
        )
        for ends in self.ends:
            push_facets(ends.pair, self.factors, state, offset=rows.offset)
        return True

    def _written(self) -> bool:
        count = 0
        for ends in self.ends:
            pair, address = ends.pair, self.rows.packed.address
            count = factored_gradients.write_gradients(
                pair.address, ends.bound.address, pair.count, pair.first_slot, count, address
            )
            if count < 0:
                return False
        self.factors.count = count
        return True

    def solve(self, compliance: Floats, multipliers: Floats, force: Floats) -> Solve | None:
        """See `Reduced`."""
        return self.enforcement.solve_gradients(self.rows, compliance, multipliers, force)


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
