"""The rows of T^-T D^T and T^-T M^T, each over its own stretch of the chain.

Row k holds the weights with which surface nodes enter condition k. Columns of T^-1 decay by a
constant factor per node (0.17 for P0, 0.27 for P1), so every row is cut where its weights fall below
`CUT`; what is left is a contiguous window of chain positions, `start[k]` <= position < `end[k]`,
stored from the beginning of `weight[k]`.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section

FAR = 1e300  # gap of a multiplier that is not kept
CUT = 1e-14  # a weight below it moves a gap by less than the round-off of the positions


@kernel
def columns(count, multiplier, nodes, values, owner, start, end, weight):
    """Columns of D or M (pieces, b, w) as windows of their kept multipliers.

    Returns 0, or the width that `weight` (k, width) lacks.
    """
    width, rows = multiplier.shape[1], nodes.shape[1]
    for k in range(start.size):
        start[k], end[k] = 2147483647, 0
    for p in range(count):
        low, high = nodes[p, 0], nodes[p, 0]
        for i in range(1, rows):
            low, high = min(low, nodes[p, i]), max(high, nodes[p, i])
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                start[k], end[k] = min(start[k], low), max(end[k], high + 1)
    needed = 0
    for k in range(start.size):
        needed = max(needed, end[k] - start[k])
    if needed > weight.shape[1]:
        return needed
    for k in range(start.size):
        for i in range(end[k] - start[k]):
            weight[k, i] = 0.0
    for p in range(count):
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                shift = start[k]
                for i in range(rows):
                    weight[k, nodes[p, i] - shift] += values[p, i, j]
    return 0


@kernel
def _combine(k, other, factor, scale, start, end, weight, row):
    """Row k becomes scale * (row k - factor * row other); returns 0 or the width it lacks."""
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
        row[i] = 0.0
    for i in range(own, end[k]):
        row[i - begin] = scale * weight[k, i - own]
    shift, back, product = begin, start[other], scale * factor
    for i in range(low, high):
        row[i - shift] -= product * weight[other, i - back]
    for i in range(finish - begin):
        weight[k, i] = row[i]
    start[k], end[k] = begin, finish
    return 0


@section
def solve_windows(count, order, lower, upper, next_, previous, from_left, start, end, weight, row):
    """Turn columns into rows: forward and backward substitution with T^T, whole windows at a time.

    Returns 0, or the width that `weight` lacks.
    """
    for i in range(count):
        k = order[i]
        p = previous[k]
        factor = upper[p] if p >= 0 else 0.0
        needed = _combine(k, p if p >= 0 else k, factor, 1.0 / from_left[k], start, end, weight, row)
        if needed > 0:
            return needed
    for i in range(count - 1, -1, -1):
        k = order[i]
        n = next_[k]
        if n >= 0:
            needed = _combine(k, n, lower[n] / from_left[k], 1.0, start, end, weight, row)
            if needed > 0:
                return needed
    return 0


@kernel
def solved(kept, order, lower, upper, next_, previous, from_left, column, start, end, weight, row):
    """Columns (start, end, weight) copied, then `solve_windows`; returns 0 or the width that `weight` lacks."""
    first, last, value = column
    needed = 0
    for k in range(start.size):
        needed = max(needed, last[k] - first[k])
    if needed > weight.shape[1]:
        return needed
    for k in range(start.size):
        start[k], end[k] = first[k], last[k]
        for i in range(last[k] - first[k]):
            weight[k, i] = value[k, i]
    return solve_windows(kept, order, lower, upper, next_, previous, from_left, start, end, weight, row)


@kernel
def identity(count, order, nodes, start, end, weight):
    """Windows of conditions that weigh their own slave node alone, k modulo the number of nodes."""
    for i in range(count):
        k = order[i]
        start[k], end[k] = k % nodes, k % nodes + 1
        weight[k, 0] = 1.0
