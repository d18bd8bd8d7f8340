"""Columns of D and M, and the rows of T^-T D^T and T^-T M^T, each over its own stretch of the chain.

Row k holds the weights of surface nodes in constraint k. Columns of T^-1 decay by a constant factor per node
(0.17 for P0, 0.27 for P1), so every row is cut as soon as its weights fall below `CUT`.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.tables import CouplingTable

CUT = 1e-14  # a weight below it moves a gap by less than the round-off of the positions


@kernel
def fill_columns(count, multiplier, nodes, values, owner, out):
    """Fill columns of D or M for the kept multipliers from `count` contributions (p, b, w).

    Returns 0, or the width that out.weight lacks.
    """
    start, end, weight = out.start, out.end, out.weight
    width, rows = multiplier.shape[1], nodes.shape[1]
    for k in range(start.size):
        start[k], end[k] = 2147483647, 0
    if width == rows == 2:  # the common case, as constants: without inner loops
        _reach(count, 2, 2, multiplier, nodes, owner, out)
    else:
        _reach(count, width, rows, multiplier, nodes, owner, out)
    needed = 0
    for k in range(start.size):
        needed = max(needed, end[k] - start[k])
    if needed > weight.shape[1]:
        return needed
    for k in range(start.size):
        for i in range(needed):
            weight[k, i] = 0.0
    if width == rows == 2:
        _sum(count, 2, 2, multiplier, nodes, values, owner, out)
    else:
        _sum(count, width, rows, multiplier, nodes, values, owner, out)
    return 0


@section
def _reach(count, width, rows, multiplier, nodes, owner, out):
    """Widen the stretch of each kept multiplier to the nodes of its contributions."""
    start, end = out.start, out.end
    for p in range(count):
        low, high = nodes[p, 0], nodes[p, 0]
        for i in range(1, rows):
            low, high = min(low, nodes[p, i]), max(high, nodes[p, i])
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                start[k], end[k] = min(start[k], low), max(end[k], high + 1)


@section
def _sum(count, width, rows, multiplier, nodes, values, owner, out):
    """Add the contributions to the weights of the kept multipliers."""
    start, weight = out.start, out.weight
    for p in range(count):
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                shift = start[k]
                for i in range(rows):
                    weight[k, nodes[p, i] - shift] += values[p, i, j]


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
