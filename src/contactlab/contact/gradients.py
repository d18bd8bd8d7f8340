"""Rows of consistent forces, written out: gaps differentiated by all that they depend on."""

from __future__ import annotations

from contactlab.api import Floats, GapGradients, Rows
from contactlab.contact.operator_pair import OperatorPair
from contactlab.kernels.contact import gap_gradients
from contactlab.kernels.contact.pair import FAR

NORMALS = 6  # room for derivatives of normals, for each multiplier


class PairGradients:
    """The derivatives of a pair's integration segments and normals, and the rows that follow."""

    def __init__(self, pair: OperatorPair) -> None:
        self.pair = pair
        self.own, self.general = self._room(0, pair.algorithm.gradient_nodes), self._room(0, 1)

    def _room(self, entries: int, nodes: int) -> GapGradients:
        return GapGradients.allocate(entries, self.pair.widths[1], nodes, NORMALS * self.pair.slots)

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, memory: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`, gaps as they are now, no slips yet.

        Returns the next free entry, or -1 if `out` is too small.
        """
        pair, found = self.pair, self.found(memory)
        first, margin = out.count, FAR if pair.everywhere or pair.takes_rows else min(margin, FAR)
        used = pair.count, found.count, found.normal_count
        count, end = gap_gradients.write_rows(
            pair.address, found, used, margin, multipliers, pair.first_slot, (first, entries), out
        )  # fmt: skip
        if count < 0:
            return -1
        if len(out.slip):
            if pair.sliding is None:
                out.bound[:, first:count] = 0.0
            else:
                pair.write_bounds(out, first, count)
        out.count = count
        return pair.take_rows(out, first, int(end))

    def found(self, memory: Floats) -> GapGradients:
        """Return derivatives of the last update, given by the algorithm or built from its derivatives."""
        pair = self.pair
        if pair.lumped or not pair.algorithm.gradient_nodes:
            return self._from_derivatives(memory)
        if pair.count > len(self.own.node):
            self.own = self._room(len(pair.pieces.slave), pair.algorithm.gradient_nodes)
        given = pair.algorithm.gradients(
            pair.seen(memory), pair.pieces, pair.count, pair.coupling.owner, pair.separation, self.own
        )
        return self.own if given else self._from_derivatives(memory)

    def _from_derivatives(self, memory: Floats) -> GapGradients:
        pair = self.pair
        found = pair.derivatives(memory)
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
