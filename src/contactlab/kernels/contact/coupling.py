"""The coupling T of one pair's multipliers: summed from segment contributions, merged, factorised and solved.

T is tridiagonal along the slave chain. On partial overlap a multiplier that keeps little of its length is merged
into its neighbour, a multiplier with less than 1e-6 and without neighbour is dropped (docs/theory/rows.md); merging
adds rows and columns, so T stays square and tridiagonal. Kernels work on a `CouplingTable`, which `Coupling` holds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.api.arrays import Flags
from contactlab.api.compiled.bound_arrays import BoundArrays, Flags1, Floats1, Ints1
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.contact import MERGED_BELOW

DROP_BELOW = 1e-6
# for steps that free multipliers gradually, in shares of their lengths
TIE = 0.1  # tie of a half-free multiplier, about as much as T at the overlap of release
HELD_BELOW = 0.5  # overlap up to which a multiplier merged at the start of a step stays merged,
KEPT_ABOVE = 0.6  # and share of this overlap below which a free multiplier is merged: hysteresis


class CouplingTable(NamedTuple):
    """The tridiagonal coupling T of the multipliers and its factors.

    following, preceding   (k,) multipliers of the next and previous node with multipliers on the chain, -1 at ends
    absent                 multipliers of nodes without one: places that stay empty
    fixed                  (k,) multipliers of nodes that cannot move
    least                  (k,) share of its length below which each is merged
    tie                    (k,) [mm] tie of each to the neighbour that it would be merged into, 0: none
    full, cover            (k,) [mm] length of each multiplier on full overlap, and its overlap length
    diagonal, lower, upper (k,) [mm] T[k, k], T[k, previous], T[k, next]
    pivot                  (k,) [mm] diagonal after elimination of T from the start of each chain
    owner                  (k,) the multiplier that each is merged into, -1 if it was dropped
    next, previous         (k,) neighbours among the kept multipliers, -1 at ends
    order                  (k,) kept multipliers, chain by chain; kept[0] is their number
    single                 (1,) True if each multiplier has weight on its own slave node alone, D = T
    """

    following: Ints1
    preceding: Ints1
    absent: Ints1
    fixed: Flags1
    least: Floats1
    tie: Floats1
    full: Floats1
    cover: Floats1
    diagonal: Floats1
    lower: Floats1
    upper: Floats1
    pivot: Floats1
    owner: Ints1
    next: Ints1
    previous: Ints1
    order: Ints1
    kept: Ints1
    single: Flags1


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
        following, preceding = _with_multipliers(slave, rows_per_node, carried)
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
        solve(self.bound.address, found)
        return np.where(self.owner >= 0, found[self.owner], 0.0)

    def between(self, nodes: int) -> tuple[Ints, Ints, Ints]:
        """Return slave nodes without multiplier, and the next and previous node with a multiplier for each."""
        inner = self.table.absent[self.table.absent < nodes]
        return inner, self.table.following[inner], self.table.preceding[inner]


def links(surface: Surface) -> tuple[Ints, Ints]:
    """Return the next and previous node of every node of a surface, -1 at ends."""
    into, out = surface.node_segments[:, 0], surface.node_segments[:, 1]
    following = np.where(out >= 0, surface.segments[out, 1], -1).astype(np.int32)
    return following, np.where(into >= 0, surface.segments[into, 0], -1).astype(np.int32)


def _with_multipliers(slave: Surface, slots: int, carried: Flags) -> tuple[Ints, Ints]:
    """Return the multipliers of the next and previous node with multipliers, by node and slot, -1 at ends."""
    shift = len(slave.nodes) * np.arange(slots)[:, None]
    both = []
    for side in links(slave):
        near = np.where(side >= 0, side + shift, -1).ravel()
        both.append(np.where((near >= 0) & ~carried[near], near[near], near).astype(np.int32))
    return both[0], both[1]


# --- kernels --------------------------------------------------------------------------------------------------------


@section
def accumulate(count, multiplier, T, c):
    """Sum the contributions' T into the three diagonals and the overlap length of each multiplier."""
    diagonal, lower, upper, cover, following = c.diagonal, c.lower, c.upper, c.cover, c.following
    for k in range(cover.size):
        diagonal[k], lower[k], upper[k], cover[k] = 0.0, 0.0, 0.0, 0.0
    width = multiplier.shape[1]
    if width == 2:  # the common case, without inner loops
        for p in range(count):
            a, b = multiplier[p, 0], multiplier[p, 1]
            own, to, fro, other = T[p, 0, 0], T[p, 0, 1], T[p, 1, 0], T[p, 1, 1]
            diagonal[a] += own
            diagonal[b] += other
            cover[a] += own + fro
            cover[b] += to + other
            if following[a] == b:
                upper[a] += to
                lower[b] += fro
            if following[b] == a:
                upper[b] += fro
                lower[a] += to
        return
    for p in range(count):
        for i in range(width):
            a = multiplier[p, i]
            diagonal[a] += T[p, i, i]
            for j in range(width):
                cover[a] += T[p, j, i]
                if j != i and following[a] == multiplier[p, j]:
                    upper[a] += T[p, i, j]
                    lower[multiplier[p, j]] += T[p, j, i]


@section
def merge(c):
    """Drop and merge multipliers; link the rest by `next` and `previous`."""
    owner, cover, full, lower, upper = c.owner, c.cover, c.full, c.lower, c.upper
    for k in range(owner.size):
        # a hat may extend into the overlap although the multiplier of its node does not: both count as touched
        owner[k] = k if cover[k] > 0.0 or c.diagonal[k] + lower[k] + upper[k] > 0.0 else -1
    for k in range(owner.size):
        n, p = c.following[k], c.preceding[k]
        after = owner[k] >= 0 and n >= 0 and owner[n] >= 0 and (upper[k] != 0.0 or lower[n] != 0.0)
        before = owner[k] >= 0 and p >= 0 and owner[p] >= 0 and (lower[k] != 0.0 or upper[p] != 0.0)
        c.next[k] = n if after else -1
        c.previous[k] = p if before else -1
    for k in range(owner.size):
        if owner[k] == k and (c.fixed[k] or cover[k] < c.least[k] * full[k]):
            _merge_one(k, c)
    for k in range(owner.size):
        if owner[k] == k and cover[k] < DROP_BELOW * full[k]:
            owner[k] = -1
    for k in range(owner.size):
        while owner[k] >= 0 and owner[owner[k]] != owner[k]:
            owner[k] = owner[owner[k]]
    for k in range(owner.size):
        if owner[k] == k and c.tie[k] > 0.0:
            _tie(k, c)


@section
def _tie(k, c):
    """Add tie[k] (e_k - e_n)(e_k - e_n)^T, n the neighbour that would take k: sums of rows and columns stay."""
    n, p = c.next[k], c.previous[k]
    if n >= 0 and (p < 0 or c.cover[n] >= c.cover[p]):
        c.upper[k] -= c.tie[k]
        c.lower[n] -= c.tie[k]
    elif p >= 0:
        c.lower[k] -= c.tie[k]
        c.upper[p] -= c.tie[k]
        n = p
    if n >= 0:
        c.diagonal[k] += c.tie[k]
        c.diagonal[n] += c.tie[k]


@section
def _merge_one(k, c):
    """Add row and column k to the neighbour with more overlap, if there is one."""
    n, p = c.next[k], c.previous[k]
    target = n
    if n < 0 or (p >= 0 and (c.fixed[n] or c.cover[p] > c.cover[n]) and not c.fixed[p]):
        target = p
    if target < 0 or (not c.fixed[k] and c.cover[target] < c.cover[k]):
        return
    c.owner[k] = target
    c.diagonal[target] += c.diagonal[k]
    c.cover[target] += c.cover[k]
    if target == n:
        c.diagonal[n] += c.upper[k] + c.lower[n]
        c.lower[n] = c.lower[k]
    else:
        c.diagonal[p] += c.lower[k] + c.upper[p]
        c.upper[p] = c.upper[k]
    if p >= 0:
        c.next[p] = n
    if n >= 0:
        c.previous[n] = p


@section
def factorise(c):
    """Compute pivots of T eliminated from the start of each chain, and `order`.

    `kept[0]` becomes the number of kept multipliers, or -1 if a closed chain overlaps all around: T is periodic.
    """
    count = 0
    total = 0
    for k in range(c.owner.size):
        if c.owner[k] != k:
            continue
        total += 1
        if c.previous[k] >= 0:
            continue
        j = k
        while j >= 0:
            c.pivot[j] = c.diagonal[j]
            if j != k:
                c.pivot[j] -= c.lower[j] * c.upper[c.previous[j]] / c.pivot[c.previous[j]]
            c.order[count] = j
            count += 1
            j = c.next[j]
    c.kept[0] = count if count == total else -1


@kernel
def couple(count, multiplier, T, c):
    """Accumulate the first `count` contributions, merge and factorise. Return `kept[0]`, see `factorise`."""
    accumulate(count, multiplier, T, c)
    merge(c)
    factorise(c)
    return c.kept[0]


@kernel
def solve(bound, values):
    """Overwrite values (k,) by T^-1 values; `bound` is the address of a `CouplingTable`."""
    solve_pivots(unpack(bound, CouplingTable), values)


@section
def solve_pivots(c, values):
    """Overwrite values (k,) by T^-1 values."""
    for i in range(c.kept[0]):
        k = c.order[i]
        p = c.previous[k]
        if p >= 0:
            values[k] -= c.lower[k] / c.pivot[p] * values[p]
    for i in range(c.kept[0] - 1, -1, -1):
        k = c.order[i]
        n = c.next[k]
        if n >= 0:
            values[k] -= c.upper[k] * values[n]
        values[k] /= c.pivot[k]


@kernel
def unmerged(owner, D, T, count):
    """Return whether every multiplier is kept alone or dropped, and D is T: slave weights are then the identity."""
    for k in range(owner.size):
        if owner[k] >= 0 and owner[k] != k:
            return False
    if D.shape[1] < T.shape[1]:
        return False
    for p in range(count):
        for i in range(D.shape[1]):
            for j in range(T.shape[2]):
                if D[p, i, j] != (T[p, i, j] if i < T.shape[1] else 0.0):
                    return False
    return True
