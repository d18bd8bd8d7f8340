"""The rows of T^-T D^T and T^-T M^T from columns of D and M, each over its own stretch of the chain.

Row k holds the weights of surface nodes in constraint k. Columns of T^-1 decay by a constant factor per node
(0.17 for P0, 0.27 for P1), so every row is cut as soon as its weights fall below `CUT`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api.compiled.bound_arrays import Floats1
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.coupling import Coupling, CouplingTable
from contactlab.kernels.contact.pair import BandedRows

CUT = 1e-14  # a weight below it moves a gap by less than the round-off of the positions


def rows_of(coupling: Coupling, columns: BandedRows, rows: BandedRows) -> BandedRows:
    """Return rows of T^-T A^T from columns of A, in `rows` or in wider rows."""
    return _wide_enough(lambda out, room: solved(coupling.bound.address, columns, out, room), rows)


def inverse_rows(coupling: Coupling, rows: BandedRows) -> BandedRows:
    """Return rows of T^-T, in `rows` or in wider rows."""
    return _wide_enough(lambda out, room: inverse_transposed(coupling.bound.address, out, room), rows)


def _wide_enough(fill: Callable[[BandedRows, Floats1], int], rows: BandedRows) -> BandedRows:
    while needed := fill(rows, np.zeros(rows.weight.shape[1])):
        rows = BandedRows.allocate(len(rows.start), needed + needed // 2)
    return rows


@kernel
def _combine(k, other, factor, scale, rows, scratch):
    """Set row k to scale * (row k - factor * row other). Return 0 or the width it lacks."""
    start, end, weight = rows.start, rows.end, rows.weight
    low, high = start[other], end[other]
    cut = CUT / abs(factor * scale) if factor != 0.0 else 0.0
    if factor == 0.0:
        low = high
    while low < high and abs(weight[other, low - start[other]]) < cut:
        low += 1
    while high > low and abs(weight[other, high - 1 - start[other]]) < cut:
        high -= 1
    own, begin, finish = start[k], start[k], end[k]
    if low < high:
        begin, finish = min(begin, low), max(finish, high)
    if finish - begin > weight.shape[1]:
        return finish - begin
    for i in range(finish - begin):
        scratch[i] = 0.0
    for i in range(own, end[k]):
        scratch[i - begin] = scale * weight[k, i - own]
    shift, back, product = begin, start[other], scale * factor
    for i in range(low, high):
        scratch[i - shift] -= product * weight[other, i - back]
    for i in range(finish - begin):
        weight[k, i] = scratch[i]
    start[k], end[k] = begin, finish
    return 0


@section
def solve_rows(c, rows, scratch):
    """Turn columns of A into rows of T^-T A^T: both substitutions with T^T, whole rows at a time.

    `scratch` has as many numbers as a row may have weights. Returns 0, or the width that rows.weight lacks.
    """
    for i in range(c.kept[0]):
        k = c.order[i]
        p = c.previous[k]
        factor = c.upper[p] if p >= 0 else 0.0
        needed = _combine(k, p if p >= 0 else k, factor, 1.0 / c.pivot[k], rows, scratch)
        if needed > 0:
            return needed
    for i in range(c.kept[0] - 1, -1, -1):
        k = c.order[i]
        n = c.next[k]
        if n >= 0:
            needed = _combine(k, n, c.lower[n] / c.pivot[k], 1.0, rows, scratch)
            if needed > 0:
                return needed
    return 0


@kernel
def solved(bound, columns, rows, scratch):
    """Compute rows of T^-T A^T from columns of A. Return 0 or the width that rows.weight lacks.

    `bound` is the address of a `CouplingTable`.
    """
    needed = 0
    for k in range(rows.start.size):
        needed = max(needed, columns.end[k] - columns.start[k])
    if needed > rows.weight.shape[1]:
        return needed
    for k in range(rows.start.size):
        rows.start[k], rows.end[k] = columns.start[k], columns.end[k]
        for i in range(columns.end[k] - columns.start[k]):
            rows.weight[k, i] = columns.weight[k, i]
    return solve_rows(unpack(bound, CouplingTable), rows, scratch)


@kernel
def inverse_transposed(bound, rows, scratch):
    """Compute rows of T^-T. Return 0 or the width that rows.weight lacks. `bound`: address of a `CouplingTable`."""
    c = unpack(bound, CouplingTable)
    for i in range(c.kept[0]):
        k = c.order[i]
        rows.start[k], rows.end[k], rows.weight[k, 0] = k, k + 1, 1.0
    return solve_rows(c, rows, scratch)


@kernel
def own_nodes(bound, nodes, rows):
    """Write rows of constraints with weight on their own slave node alone, k modulo the number of nodes.

    `bound` is the address of a `CouplingTable`.
    """
    c = unpack(bound, CouplingTable)
    for i in range(c.kept[0]):
        k = c.order[i]
        rows.start[k], rows.end[k] = k % nodes, k % nodes + 1
        rows.weight[k, 0] = 1.0


@kernel
def entries(chosen, rows, cut, row, column, value):
    """Write entries (row, column, value) above `cut` of the chosen rows. Return their number."""
    at = 0
    for i in range(chosen.size):
        k = chosen[i]
        for z in range(rows.start[k], rows.end[k]):
            w = rows.weight[k, z - rows.start[k]]
            if abs(w) > cut:
                row[at], column[at], value[at] = k, z, w
                at += 1
    return at
