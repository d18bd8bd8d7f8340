"""Rows of all pairs whose forces are consistent, before their coupling is inverted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contactlab.api import FactoredGradients, Floats, Ints
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.kernels.contact import factored_gradients as kernels
from contactlab.kernels.contact.factored_gradients import EndsTable

GROW = 1.5


class PairEnds:
    """Where the pieces of a pair begin and end on both segments, and room for what follows from it.

    number  (N,) numbers of global nodes, shared by all pairs of a model
    nodes   how many nodes all of them touch at most
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
        """Fill `feet` for the pieces of the last update; False where the algorithm cannot tell them."""
        pair = self.pair
        if pair.count > len(self.feet):
            self._bind(len(pair.pieces.slave))
        return pair.algorithm.feet(pair.seen(memory), pair.pieces, pair.count, self.feet)


def told_by_feet(pairs: Sequence[ContactPair]) -> list[OperatorPair]:
    """All the pairs, where their rows can be told by the ends of pieces: straight edges, and nothing that rubs."""
    return [
        pair
        for pair in pairs
        if isinstance(pair, OperatorPair)
        and all(side.edges.shape[1] == 2 for side in (pair.slave, pair.master))
        and pair.friction is None
        and not pair.pushes_overlaps_out
    ]


class ModelGradients:
    """The factored rows of a model's pairs, made anew in every step."""

    def __init__(self, pairs: Sequence[OperatorPair], nodes: int) -> None:
        self.number = np.full(nodes, -1, np.int32)
        self.touched = sum(len(pair.slave.nodes) + len(pair.master.nodes) for pair in pairs)
        self.ends = [PairEnds(pair, self.number, self.touched) for pair in pairs]
        self.rows = self._room(8 * sum(pair.slots for pair in pairs))

    def _room(self, entries: int) -> FactoredGradients:
        self.number[:] = -1
        return FactoredGradients.allocate(sum(ends.pair.slots for ends in self.ends), entries, self.touched)

    def assemble(self, memories: list[Floats]) -> bool:
        """Rows of all pairs as they were last updated; False where an algorithm cannot tell where its pieces end."""
        self.rows.factors.count = 0
        for ends, memory in zip(self.ends, memories, strict=True):
            if not ends.found(memory):
                return False
        while not self._written():
            self.rows = self._room(int(GROW * len(self.rows.factors.node)) + 64)
        return True

    def _written(self) -> bool:
        count = 0
        for ends in self.ends:
            pair, address = ends.pair, self.rows.packed.address
            count = kernels.write_gradients(
                pair.address, ends.bound.address, pair.count, pair.first_slot, count, address
            )
            if count < 0:
                return False
        self.rows.factors.count = count
        return True

    def allow_motion(self, predicted: Floats, current: Floats, velocity: Floats, last_dt: float) -> None:
        """What the conditions have to hold at the end of the step; see `contactlab.kernels.contact.gap_gradients`."""
        rows = self.rows
        kernels.allow_factored_motion(rows.factors.count, rows.packed.address, current, predicted, velocity, last_dt)
