"""An order of elimination by nested dissection: halves of the mesh first, the nodes that join them last (George 1973).

Fill-in grows with n log n, with minimum degree a little faster: minimum degree has less fill-in below some
3e5 unknowns, and takes longer and more memory above. Node positions give the cuts, the matrix gives the nodes that
join the halves, so that contact, with couplings beyond cells, is counted.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Floats

FROM = 300_000  # unknowns: of the time of factors it saves nothing at 186 000, a sixth at 740 000 (disc-on-block)
SMALLEST = 8  # nodes that are not cut any more
MOST = 36  # nested cuts: 3 to this power is the largest order number that fits into 64 bits

Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]


def dissected(matrix: Any, places: Floats) -> Numbers:
    """Return the order (n,) in which the unknowns of a CSC matrix of symmetric pattern are eliminated.

    places  (m, 2) [mm] of the first m unknowns; further unknowns are placed at the unknowns coupled with them
    """
    row, column = matrix.indices, np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    known = len(places)
    places = _all_places(row, column, places, matrix.shape[0])
    # both directions of a node are cut together, and one coupling of two nodes represents all four
    first = np.ones(len(places), bool)
    first[1:known] = (places[1:known] != places[: known - 1]).any(axis=1)
    vertex = np.cumsum(first) - 1
    edges = np.flatnonzero(first[row] & first[column] & (row != column))
    code = _codes(vertex[row[edges]], vertex[column[edges]], places[first])
    return np.argsort(code[vertex], kind="stable")


def _all_places(row: Any, column: Any, places: Floats, number: int) -> Floats:
    """Return places of all unknowns: for the last ones the mean of their coupled unknowns."""
    known = len(places)
    with_known = (column >= known) & (row < known)
    beyond, of = column[with_known] - known, places[row[with_known]]
    count = np.maximum(np.bincount(beyond, minlength=number - known), 1)
    sums = [np.bincount(beyond, of[:, k], number - known) for k in range(2)]
    return np.concatenate([places, np.stack(sums, axis=1) / count[:, None]])


def _codes(row: Numbers, column: Numbers, places: Floats) -> Numbers:
    """Return numbers (v,) by which vertices, coupled pair by pair (e,), are sorted: one digit of base 3 for each cut.

    0 and 1 are the halves of a piece, 2 the vertices between them; uncut pieces get further digits 0.
    """
    code, part = (np.zeros(len(places), np.int64) for _ in range(2))
    left = np.arange(len(places))
    for _ in range(MOST):
        large = np.bincount(part[left])[part[left]] > SMALLEST
        part[left[~large]] = -1
        left = left[large]
        if not len(left):
            break
        edges = (part[row] >= 0) & (part[row] == part[column])
        row, column = row[edges], column[edges]
        upper, between = _cut(left, part, row, column, places)
        code *= 3
        code[left] += np.where(between[left], 2, upper[left])
        left = left[~between[left]]
        half = 2 * part[left] + upper[left]
        part[:] = -1
        part[left] = (np.cumsum(np.bincount(half) > 0) - 1)[half]
    return code


def _cut(left: Numbers, part: Numbers, row: Numbers, column: Numbers, places: Floats) -> tuple[Flags, Flags]:
    """Return vertices (v,) of the upper half of each piece, and its vertices coupled with the lower half.

    Pieces are cut in the middle, along the axis that leaves fewer between the halves.
    """
    of = part[left]
    size = np.bincount(of)
    middle = np.minimum(np.cumsum(size) - size + size // 2, len(left) - 1)
    halves = []
    for value in places.T:
        order = left[np.lexsort((value[left], of))]
        upper = value >= value[order[middle]][part]
        between = np.zeros(len(part), bool)
        between[row[upper[row] & ~upper[column]]] = True
        count = np.bincount(of, between[left], len(size))
        count[np.bincount(of, ~upper[left], len(size)) == 0] = np.inf  # all of them lie on one line
        halves.append((upper, between, count))
    (first, within, few), (second, beside, many) = halves
    along = (few <= many)[part]
    return np.where(along, first, second), np.where(along, within, beside)
