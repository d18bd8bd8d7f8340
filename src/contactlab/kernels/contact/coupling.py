"""From local pieces to the coupling T of the multipliers: merged, dropped and factorised.

T is tridiagonal along the slave chain (`diagonal`, `lower[k]` = T[k, previous], `upper[k]` =
T[k, next]). On partial cover a multiplier that keeps less than 5 % of its length is merged into its
neighbour, one that has none and keeps less than 1e-6 is dropped (docs/theory/rows.md); merging
adds rows and columns, so T stays square and tridiagonal. `owner[k]` is the multiplier that k became, -1 if dropped.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section

MERGE_BELOW = 0.05
DROP_BELOW = 1e-6


@section
def accumulate(count, multiplier, T, following, diagonal, lower, upper, cover):
    """Sum the pieces' T into the three diagonals and the covered length of each multiplier."""
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
def settle(full, fixed, following, preceding, diagonal, lower, upper, cover, owner, next_, previous):
    """Drop and merge multipliers; link the rest in `next_` and `previous` (-1 at ends).

    `full` (k,) [mm] is the length of each multiplier on full cover; `fixed` (k,) marks multipliers
    of nodes that cannot move, which are merged whatever they cover.
    """
    for k in range(owner.size):
        # a hat may reach into the cover where the multiplier of its node does not: both count as touched
        owner[k] = k if cover[k] > 0.0 or diagonal[k] + lower[k] + upper[k] > 0.0 else -1
    for k in range(owner.size):
        n, p = following[k], preceding[k]
        next_[k] = n if owner[k] >= 0 and n >= 0 and owner[n] >= 0 and (upper[k] != 0.0 or lower[n] != 0.0) else -1
        previous[k] = p if owner[k] >= 0 and p >= 0 and owner[p] >= 0 and (lower[k] != 0.0 or upper[p] != 0.0) else -1
    for k in range(owner.size):
        if owner[k] == k and (fixed[k] or cover[k] < MERGE_BELOW * full[k]):
            _merge(k, fixed, diagonal, lower, upper, cover, owner, next_, previous)
    for k in range(owner.size):
        if owner[k] == k and cover[k] < DROP_BELOW * full[k]:
            owner[k] = -1
    for k in range(owner.size):
        while owner[k] >= 0 and owner[owner[k]] != owner[k]:
            owner[k] = owner[owner[k]]


@section
def _merge(k, fixed, diagonal, lower, upper, cover, owner, next_, previous):
    """Give row and column k to the neighbour with more cover, if there is one to take them."""
    n, p = next_[k], previous[k]
    target = n
    if n < 0 or (p >= 0 and (fixed[n] or cover[p] > cover[n]) and not fixed[p]):
        target = p
    if target < 0 or (not fixed[k] and cover[target] < cover[k]):
        return
    owner[k] = target
    diagonal[target] += diagonal[k]
    cover[target] += cover[k]
    if target == n:
        diagonal[n] += upper[k] + lower[n]
        lower[n] = lower[k]
    else:
        diagonal[p] += lower[k] + upper[p]
        upper[p] = upper[k]
    if p >= 0:
        next_[p] = n
    if n >= 0:
        previous[n] = p


@section
def factorise(diagonal, lower, upper, owner, next_, previous, from_left, order):
    """Pivots of T eliminated from the start of each chain; `order` lists the multipliers chain by chain.

    Returns their number, or -1 where a closed chain is covered all around (T is then periodic).
    """
    count = 0
    total = 0
    for k in range(owner.size):
        if owner[k] != k:
            continue
        total += 1
        if previous[k] >= 0:
            continue
        j = k
        while j >= 0:
            from_left[j] = diagonal[j]
            if j != k:
                from_left[j] -= lower[j] * upper[previous[j]] / from_left[previous[j]]
            order[count] = j
            count += 1
            j = next_[j]
    return count if count == total else -1


@kernel
def couple(
    count, multiplier, T, full, fixed, following, preceding, diagonal, lower, upper, cover, owner, next_, previous,
    from_left, order,
):  # fmt: skip
    """Accumulate, settle and factorise; returns the number of kept multipliers or -1 (see `factorise`)."""
    accumulate(count, multiplier, T, following, diagonal, lower, upper, cover)
    settle(full, fixed, following, preceding, diagonal, lower, upper, cover, owner, next_, previous)
    return factorise(diagonal, lower, upper, owner, next_, previous, from_left, order)


@kernel
def solve(count, order, lower, upper, next_, previous, from_left, values):
    """Overwrite values (k,) by T^-1 values."""
    for i in range(count):
        k = order[i]
        p = previous[k]
        if p >= 0:
            values[k] -= lower[k] / from_left[p] * values[p]
    for i in range(count - 1, -1, -1):
        k = order[i]
        n = next_[k]
        if n >= 0:
            values[k] -= upper[k] * values[n]
        values[k] /= from_left[k]


@kernel
def unmerged(owner, D, T, count):
    """Whether every multiplier is kept as it is or dropped, and D is T: slave weights are then the identity."""
    for k in range(owner.size):
        if owner[k] >= 0 and owner[k] != k:
            return False
    if D.shape[1] != T.shape[1]:
        return False
    for p in range(count):
        for i in range(T.shape[1]):
            for j in range(T.shape[2]):
                if D[p, i, j] != T[p, i, j]:
                    return False
    return True
