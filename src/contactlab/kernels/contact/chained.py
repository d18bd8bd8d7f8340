"""Conditions of a pair as columns of D and M and the coupling T, without the rows T^-T [D^T | -M^T].

A row reaches along the whole contact, a column over the few nodes that share a piece with its multiplier.
Whatever rows do to vectors, columns and two substitutions with T do in O(conditions).
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section


@section
def weigh(k, column, at, sign, out):
    """Add sign times the weighted sum of positions `at` over column k to out[k]."""
    start, end, weight = column
    shift = start[k]
    x, y = 0.0, 0.0
    for z in range(start[k], end[k]):
        x += weight[k, z - shift] * at[z, 0]
        y += weight[k, z - shift] * at[z, 1]
    out[k, 0] += sign * x
    out[k, 1] += sign * y


@section
def solve_transposed(count, order, lower, upper, next_, previous, from_left, values):
    """Overwrite values (k, 2) by T^-T values."""
    for i in range(count):
        k = order[i]
        p = previous[k]
        for c in range(2):
            if p >= 0:
                values[k, c] -= upper[p] * values[p, c]
            values[k, c] /= from_left[k]
    for i in range(count - 1, -1, -1):
        k = order[i]
        n = next_[k]
        if n >= 0:
            for c in range(2):
                values[k, c] -= lower[n] / from_left[k] * values[n, c]


@kernel
def separations(
    count, order, lower, upper, next_, previous, from_left, single, slave, master, slave_at, master_at, normals, far,
    separation, gaps,
):  # fmt: skip
    """Vector from the master's to the slave's weighted position, its normal and tangential part (k, 2).

    `slave`, `master` = (start, end, weight) are columns; where `single` every condition weighs its own slave
    node alone and `slave` is not read. Conditions that are not kept count as `far` open.
    """
    for k in range(gaps.shape[0]):
        gaps[k, 0] = far
    for i in range(count):
        k = order[i]
        separation[k, 0], separation[k, 1] = 0.0, 0.0
        weigh(k, master, master_at, -1.0, separation)
        if not single:
            weigh(k, slave, slave_at, 1.0, separation)
    solve_transposed(count, order, lower, upper, next_, previous, from_left, separation)
    for i in range(count):
        k = order[i]
        if single:
            node = k % slave_at.shape[0]
            separation[k, 0] += slave_at[node, 0]
            separation[k, 1] += slave_at[node, 1]
        x, y = separation[k, 0], separation[k, 1]
        gaps[k, 0] = normals[k, 0] * x + normals[k, 1] * y
        gaps[k, 1] = normals[k, 1] * x - normals[k, 0] * y


@section
def _write_column(k, column, sign, numbers, at, node, weight):
    start, end, values = column
    for z in range(start[k], end[k]):
        w = values[k, z - start[k]]
        if w != 0.0:
            node[at], weight[at] = numbers[z], sign * w
            at += 1
    return at


@kernel
def write_rows(
    count, order, lower, upper, previous, from_left, single, slave, master, slave_nodes, master_nodes, normals, gaps,
    sizes, first_slot, row, out,
):  # fmt: skip
    """Append all conditions of a pair to those of the model; returns their number, or -1 if out of room.

    out = the arrays of `ChainedRows`
    """
    start, node, weight, own, normal, gap, size, slot, above, below, inverse, _ = out
    at = start[row]
    for i in range(count):
        k = order[i]
        room = master[1][k] - master[0][k] + (0 if single else slave[1][k] - slave[0][k])
        if row >= gap.size or at + max(room, 0) > node.size:
            return -1
        at = _write_column(k, master, -1.0, master_nodes, at, node, weight)
        if not single:
            at = _write_column(k, slave, 1.0, slave_nodes, at, node, weight)
        p = previous[k]
        own[row] = slave_nodes[k % slave_nodes.size] if single else -1
        normal[row, 0], normal[row, 1] = normals[k, 0], normals[k, 1]
        gap[row], size[row], slot[row] = gaps[k, 0], sizes[k], first_slot + k
        above[row], below[row] = (upper[p], lower[k]) if p >= 0 else (0.0, 0.0)
        inverse[row] = 1.0 / from_left[k]
        row += 1
        start[row] = at
    return row
