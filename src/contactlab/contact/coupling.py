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

# for steps that free multipliers gradually, in shares of their lengths
TIE = 0.1  # tie of a half-free multiplier, about as much as T at the overlap of release
HELD_BELOW = 0.5  # overlap up to which a multiplier merged at the start of a step stays merged,
KEPT_ABOVE = 0.6  # and share of this overlap below which a free multiplier is merged: hysteresis


class Coupling:
    """The tridiagonal T of k multipliers: merged and dropped if they have little overlap, and factorised.

    `table` holds its arrays, which the kernels of a pair fill from segment contributions. `carriers` (m,) marks slave
    nodes with multipliers, `fixed` (m,) nodes that cannot move: these multipliers are merged at any overlap.
    `merged_below` is the share of its length below which `let_go` and the code after it merge a multiplier.
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
        """The owner (k,) that each multiplier is merged into, -1 if it was dropped."""
        return self.table.owner

    @property
    def cover(self) -> Floats:
        """Overlap length (k,) [mm] of each multiplier."""
        return self.table.cover

    @property
    def full(self) -> Floats:
        """Length (k,) [mm] of each multiplier on full overlap."""
        return self.table.full

    @property
    def fixed(self) -> Flags:
        """Slave nodes (m,) that cannot move."""
        nodes = len(self.table.fixed) // self.rows_per_node
        return self.table.fixed[:nodes]

    @property
    def free(self) -> Flags:
        """Multipliers (k,) that are neither merged nor dropped."""
        free: Flags = self.owner == np.arange(len(self.owner), dtype=np.int32)
        return free

    def let_go(self) -> None:
        """Tie nothing, and merge multipliers with too little overlap: the coupling of the theory."""
        self.table.least[:], self.table.tie[:] = self.merged_below, 0.0

    def untie(self, freedom: Floats) -> None:
        """Tie nothing; a multiplier with some `freedom` (k,) is merged later than a multiplier that comes free."""
        self.table.least[:] = np.where(freedom > 0.0, KEPT_ABOVE * self.merged_below, self.merged_below)
        self.table.tie[:] = 0.0

    def hold(self, freedom: Floats) -> None:
        """Release every multiplier by `freedom` (k,): 1 frees it, 0 holds it merged until half overlaps.

        In between it is tied to the neighbour that it would be merged into, less so with more freedom.
        """
        t = self.table
        t.least[:] = np.where(freedom > 0.0, KEPT_ABOVE * self.merged_below, HELD_BELOW)
        part = (freedom > 0.0) & (freedom < 1.0)
        t.tie[:] = 0.0
        t.tie[part] = TIE * t.full[part] * (1.0 / freedom[part] - 1.0)

    def solve(self, values: Floats) -> Floats:
        """Return T^-1 values (k,): the owner's value if merged, 0 if dropped."""
        found = np.array(values)
        coupling.solve(self.bound.address, found)
        return np.where(self.owner >= 0, found[self.owner], 0.0)

    def between(self, nodes: int) -> tuple[Ints, Ints, Ints]:
        """Return slave nodes without multiplier, and the next and previous node with a multiplier for each."""
        inner = self.table.absent[self.table.absent < nodes]
        return inner, self.table.following[inner], self.table.preceding[inner]

    def rows(self, columns: BandedRows, rows: BandedRows) -> BandedRows:
        """Return rows of T^-T A^T from columns of A, in `rows` or in wider rows."""
        return self._wide_enough(lambda out, room: banded_rows.solved(self.bound.address, columns, out, room), rows)

    def inverse_transposed(self, rows: BandedRows) -> BandedRows:
        """Return rows of T^-T, in `rows` or in wider rows."""
        return self._wide_enough(lambda out, room: banded_rows.inverse_transposed(self.bound.address, out, room), rows)

    def _wide_enough(self, fill: Callable[[BandedRows, Floats], int], rows: BandedRows) -> BandedRows:
        while True:
            if rows.weight.shape[1] > len(self._scratch):
                self._scratch = np.zeros(rows.weight.shape[1])
            if not (needed := fill(rows, self._scratch)):
                return rows
            rows = BandedRows.allocate(len(self.owner), needed + needed // 2)


def _neighbours(slave: Surface, slots: int, carried: Flags) -> tuple[Ints, Ints]:
    """Return the multipliers of the next and previous node with multipliers, by node and slot, -1 at ends."""
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
