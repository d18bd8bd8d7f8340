"""The coupling T of one pair's multipliers as an object, and the banded rows that follow from it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.api.arrays import Flags
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.contact import MERGED_BELOW
from contactlab.kernels.contact import banded_rows, coupling
from contactlab.kernels.contact.tables import BandedRows, CouplingTable

# for steps that free multipliers by and by, in shares of their lengths
TIE = 0.1  # what ties a multiplier that is half free, about as much as T does at the cover where one comes free
HELD_BELOW = 0.5  # one that is merged at the start of a step can be held so up to this cover,
KEPT_ABOVE = 0.6  # and one that is free is merged below this share of that cover: it does not come and go


class Coupling:
    """The tridiagonal T of k multipliers: merged and dropped where little of them is covered, and factorised.

    `table` holds its arrays, which the kernels of a pair fill from segment contributions. `carriers` (m,) marks slave
    nodes that carry multipliers, `fixed` (m,) those that cannot move: theirs are merged whatever they cover.
    `merged_below` is the share of its length below which `let_go` and what follows it merge a multiplier.
    """

    def __init__(
        self, slave: Surface, rows_per_node: int, carriers: Flags, fixed: Flags, merged_below: float = MERGED_BELOW
    ) -> None:
        self.rows_per_node, self.merged_below = rows_per_node, merged_below
        carried = np.tile(carriers, rows_per_node)
        following, preceding = _neighbours(slave, rows_per_node, carried)
        absent = np.flatnonzero(~carried).astype(np.int32)
        k = len(following)
        tie, full, cover, diagonal, lower, upper, pivot = np.zeros((7, k))
        owner, next_, previous, order = np.zeros((4, k), np.int32)
        self.table = CouplingTable(
            following, preceding, absent, np.tile(fixed, rows_per_node), np.full(k, MERGED_BELOW), tie, full,
            cover, diagonal, lower, upper, pivot, owner, next_, previous, order, np.zeros(1, np.int32),
            np.zeros(1, np.bool_),
        )  # fmt: skip
        self.bound = BoundArrays(CouplingTable, *self.table)
        self._scratch = np.zeros(0)

    @property
    def order(self) -> Ints:
        """Numbers of the kept multipliers, chain by chain."""
        return self.table.order[: self.table.kept[0]]

    @property
    def owner(self) -> Ints:
        """The multiplier (k,) that each one became, -1 if it was dropped."""
        return self.table.owner

    @property
    def cover(self) -> Floats:
        """Covered length (k,) [mm] of each multiplier."""
        return self.table.cover

    @property
    def full(self) -> Floats:
        """Length (k,) [mm] of each multiplier on full cover."""
        return self.table.full

    @property
    def fixed(self) -> Flags:
        """Which slave nodes (m,) cannot move."""
        nodes = len(self.table.fixed) // self.rows_per_node
        return self.table.fixed[:nodes]

    @property
    def free(self) -> Flags:
        """Which multipliers (k,) are neither merged nor dropped."""
        free: Flags = self.owner == np.arange(len(self.owner), dtype=np.int32)
        return free

    def let_go(self) -> None:
        """Tie nothing, and merge what keeps too little of its length: the coupling as the theory has it."""
        self.table.least[:], self.table.tie[:] = self.merged_below, 0.0

    def untie(self, freedom: Floats) -> None:
        """Tie nothing; what has some `freedom` (k,) is merged later than what comes free."""
        self.table.least[:] = np.where(freedom > 0.0, KEPT_ABOVE * self.merged_below, self.merged_below)
        self.table.tie[:] = 0.0

    def hold(self, freedom: Floats) -> None:
        """Let every multiplier go as far as `freedom` (k,) says: 1 frees it, 0 holds it merged until half is covered.

        In between it is tied to the neighbour that it would be merged into, the less the more of it is free.
        """
        t = self.table
        t.least[:] = np.where(freedom > 0.0, KEPT_ABOVE * self.merged_below, HELD_BELOW)
        part = (freedom > 0.0) & (freedom < 1.0)
        t.tie[:] = 0.0
        t.tie[part] = TIE * t.full[part] * (1.0 / freedom[part] - 1.0)

    def solve(self, values: Floats) -> Floats:
        """T^-1 values (k,), those of the owner where multipliers are merged, 0 where they are dropped."""
        found = np.array(values)
        coupling.solve(self.bound.address, found)
        return np.where(self.owner >= 0, found[self.owner], 0.0)

    def between(self, nodes: int) -> tuple[Ints, Ints, Ints]:
        """Those of the slave's nodes that carry no multiplier, and the carriers that follow and precede each."""
        inner = self.table.absent[self.table.absent < nodes]
        return inner, self.table.following[inner], self.table.preceding[inner]

    def rows(self, columns: BandedRows, rows: BandedRows) -> BandedRows:
        """Rows of T^-T A^T from columns of A, in `rows` or in wider ones."""
        return self._wide_enough(lambda out, room: banded_rows.solved(self.bound.address, columns, out, room), rows)

    def inverse_transposed(self, rows: BandedRows) -> BandedRows:
        """Rows of T^-T, in `rows` or in wider ones."""
        return self._wide_enough(lambda out, room: banded_rows.inverse_transposed(self.bound.address, out, room), rows)

    def _wide_enough(self, fill: Callable[[BandedRows, Floats], int], rows: BandedRows) -> BandedRows:
        while True:
            if rows.weight.shape[1] > len(self._scratch):
                self._scratch = np.zeros(rows.weight.shape[1])
            if not (needed := fill(rows, self._scratch)):
                return rows
            rows = BandedRows.allocate(len(self.owner), needed + needed // 2)


def _neighbours(slave: Surface, slots: int, carried: Flags) -> tuple[Ints, Ints]:
    """For every node and slot the multipliers of the next and of the previous carrier of the chain, -1 at ends."""
    m = len(slave.nodes)
    into, out = slave.node_segments[:, 0], slave.node_segments[:, 1]
    following = np.where(out >= 0, slave.segments[out, 1], -1)
    preceding = np.where(into >= 0, slave.segments[into, 0], -1)
    shift = m * np.arange(slots)[:, None]
    both = []
    for side in (following, preceding):
        near = np.where(side >= 0, side + shift, -1).ravel()
        both.append(np.where((near >= 0) & ~carried[near], near[near], near).astype(np.int32))
    return both[0], both[1]
