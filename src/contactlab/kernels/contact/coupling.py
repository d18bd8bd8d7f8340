"""From segment contributions to the coupling T of the multipliers: merged, dropped, factorised and solved.

T is tridiagonal along the slave chain. On partial overlap a multiplier that keeps little of its length is merged
into its neighbour, a multiplier with less than 1e-6 and without neighbour is dropped (docs/theory/rows.md); merging
adds rows and columns, so T stays square and tridiagonal. All kernels work on a `CouplingTable`.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.tables import CouplingTable

DROP_BELOW = 1e-6


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

    `kept[0]` becomes the number of kept multipliers, or -1 if a closed chain overlaps all around (T is then
    periodic).
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
