"""Tables of the kernels of one contact pair: k multipliers, m slave nodes, l master nodes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Pieces
from contactlab.api.compiled.bound_arrays import Flags1, Floats1, Floats2, Ints1, Ints2


class BandedRows(NamedTuple):
    """Rows with weights on one stretch of a chain of nodes each.

    Row k weights the positions start[k] <= p < end[k] by weight[k, p - start[k]].
    """

    start: Ints1
    end: Ints1
    weight: Floats2

    @classmethod
    def allocate(cls, rows: int, width: int) -> BandedRows:
        """Allocate empty rows of at most `width` weights."""
        return cls(np.zeros(rows, np.int32), np.zeros(rows, np.int32), np.zeros((rows, width)))


class CouplingTable(NamedTuple):
    """The tridiagonal coupling T of the multipliers and its factors; see `contactlab.kernels.contact.coupling`.

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


class PlacesTable(NamedTuple):
    """Nodes and positions of a pair.

    slave, master           (m,), (l,) global nodes
    segments, node_segments of the slave
    slave_at, master_at     (m, 2), (l, 2) [mm] for the integration of D, M and T
    slave_measured, master_measured  [mm] for the measurement of gaps
    slave_before, master_before      [mm] of the near list
    """

    slave: Ints1
    master: Ints1
    segments: Ints2
    node_segments: Ints2
    slave_at: Floats2
    master_at: Floats2
    slave_measured: Floats2
    master_measured: Floats2
    slave_before: Floats2
    master_before: Floats2


class BothSides(NamedTuple):
    """Banded rows over the slave's nodes and over the master's nodes, of one multiplier each."""

    slave: BandedRows
    master: BandedRows


class PairTable(NamedTuple):
    """All arrays of the kernels of one pair.

    columns     of D and M for each multiplier
    separation  (k, 2) [mm] weighted slave positions minus weighted master positions, gaps (k, 2) [mm] their normal and
                tangential parts
    weights     rows T^-T D^T and T^-T M^T
    """

    places: PlacesTable
    coupling: CouplingTable
    pieces: Pieces
    columns: BothSides
    separation: Floats2
    gaps: Floats2
    weights: BothSides
