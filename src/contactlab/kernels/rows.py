"""Gap rows G = T^-T [D^T | -M^T] . normal from the columns of D and M.

The columns of T^-1 decay by a constant factor per node (0.17 for P0, 0.27 for P1), so a row is
the sum of the columns of D and M over a short window, weighted by one column of T^-1 that two
recursions give, one to either side.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.kernel import kernel

CUT = 1e-12  # weights below it change a gap by less than round-off of the positions


@kernel
def columns(count, multiplier, nodes, values, owner, start, node, value, scratch, fill):
    """Compress the pieces' local columns into one sparse column per kept multiplier.

    nodes (capacity, b) and values (capacity, b, w) are D or M of the pieces; `start` (k + 1),
    `node` and `value` receive the columns; `scratch` (nodes,) is zero on entry and on exit.
    """
    width, rows = multiplier.shape[1], nodes.shape[1]
    start[:] = 0
    for p in range(count):
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                start[k + 1] += rows
    for k in range(start.size - 1):
        start[k + 1] += start[k]
        fill[k] = start[k]
    for p in range(count):
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k < 0:
                continue
            for i in range(rows):
                node[fill[k]] = nodes[p, i]
                value[fill[k]] = values[p, i, j]
                fill[k] += 1
    # add entries of the same node up; packed columns stay inside their own room
    for k in range(start.size - 1):
        write = start[k]
        for z in range(start[k], fill[k]):
            scratch[node[z]] += value[z]
        for z in range(start[k], fill[k]):
            total = scratch[node[z]]
            if total != 0.0:
                scratch[node[z]] = 0.0
                node[write] = node[z]
                value[write] = total
                write += 1
        fill[k] = write


@kernel
def weighted_positions(count, order, start, end, node, value, positions, sign, out):
    """Add sign * sum of value * position over the columns to out (k, 2) for the kept multipliers."""
    for i in range(count):
        k = order[i]
        x, y = 0.0, 0.0
        for z in range(start[k], end[k]):
            x += value[z] * positions[node[z], 0]
            y += value[z] * positions[node[z], 1]
        out[k, 0] += sign * x
        out[k, 1] += sign * y


@kernel
def _window(k, lower, upper, next_, previous, diagonal, from_left, from_right, members, factors):
    """Column k of T^-1: the multipliers where it is not negligible and its values there."""
    members[0] = k
    factors[0] = 1.0 / (from_left[k] + from_right[k] - diagonal[k])
    count = 1
    smallest = 0.1 * CUT * abs(factors[0])
    j, factor = next_[k], factors[0]
    while j >= 0:
        factor *= -lower[j] / from_right[j]
        if abs(factor) < smallest:
            break
        members[count] = j
        factors[count] = factor
        count += 1
        j = next_[j]
    j, factor = previous[k], factors[0]
    while j >= 0:
        factor *= -upper[j] / from_left[j]
        if abs(factor) < smallest:
            break
        members[count] = j
        factors[count] = factor
        count += 1
        j = previous[j]
    return count


@kernel
def _spread(window, members, factors, start, end, node, value, weight, touched):
    """Sum the columns of the window into `weight`; returns how many nodes were touched."""
    count = 0
    for i in range(window):
        for z in range(start[members[i]], end[members[i]]):
            n = node[z]
            if weight[n] == 0.0:
                touched[count] = n
                count += 1
                weight[n] = 1e-300  # marks the node as touched even if its sum is still zero
            weight[n] += factors[i] * value[z]
    return count


@kernel
def _emit(count, touched, weight, sign, numbers, normal, at, row_node, row_normal, row_tangent):
    """Move touched weights into the row's entries and clear them; returns the next free entry."""
    for i in range(count):
        n = touched[i]
        w = weight[n]
        weight[n] = 0.0
        if abs(w) < CUT:
            continue
        row_node[at] = numbers[n]
        row_normal[at, 0] = sign * w * normal[0]
        row_normal[at, 1] = sign * w * normal[1]
        if row_tangent.shape[0] > 0:
            row_tangent[at, 0] = sign * w * normal[1]
            row_tangent[at, 1] = -sign * w * normal[0]
        at += 1
    return at


@kernel
def emit_row(k, coupling, slave, master, normal, rows, at):
    """Append row k to the sparse rows from entry `at`; returns the next free entry, -1 if it does not fit.

    coupling = (diagonal, lower, upper, next_, previous, from_left, from_right, members, factors)
    slave, master = (start, end, node, value, weight, touched, numbers)
    rows = (row_node, row_normal, row_tangent)
    """
    diagonal, lower, upper, next_, previous, from_left, from_right, members, factors = coupling
    window = _window(k, lower, upper, next_, previous, diagonal, from_left, from_right, members, factors)
    row_node, row_normal, row_tangent = rows
    start, end, node, value, weight, touched, numbers = slave
    if at + weight.size + master[4].size > row_node.size:
        return -1
    count = _spread(window, members, factors, start, end, node, value, weight, touched)
    at = _emit(count, touched, weight, 1.0, numbers, normal, at, row_node, row_normal, row_tangent)
    start, end, node, value, weight, touched, numbers = master
    count = _spread(window, members, factors, start, end, node, value, weight, touched)
    return _emit(count, touched, weight, -1.0, numbers, normal, at, row_node, row_normal, row_tangent)


@kernel
def emit_rows(
    count, order, wanted, coupling, slave, master, normals, before, current, rows, first_row, first_entry, table
):
    """Append the wanted rows of one contact pair to the model's rows; returns (rows, entries) or (-1, 0).

    table = (start, gap, slip, measure, size, slot, gaps (k,), cover (k,), sizes (k,), first slot)
    `before` (k, 2) are the normals at the start of the step and `current` (N, 2) the positions
    there; both empty without friction.
    """
    start, gap, slip, measure, size, slot, gaps, cover, sizes, first_slot = table
    row, at = first_row, first_entry
    for i in range(count):
        k = order[i]
        if not wanted[k]:
            continue
        if row >= gap.size:
            return -1, 0
        end = emit_row(k, coupling, slave, master, normals[k], rows, at)
        if end < 0:
            return -1, 0
        start[row] = at
        start[row + 1] = end
        gap[row] = gaps[k, 0]
        measure[row] = cover[k]
        size[row] = sizes[k]
        slot[row] = first_slot + k
        if before.shape[0] > 0:
            slip[row] = gaps[k, 1] - _slip_before(rows[0], rows[1], at, end, normals[k], before[k], current)
        at = end
        row += 1
    return row, at


@kernel
def _slip_before(node, weight, begin, end, normal, before, current):
    """Tangent times separation at the start of the step, with the row's own weights."""
    rx, ry = 0.0, 0.0
    for z in range(begin, end):
        w = weight[z, 0] * normal[0] + weight[z, 1] * normal[1]
        rx += w * current[node[z], 0]
        ry += w * current[node[z], 1]
    return before[1] * rx - before[0] * ry


@kernel
def gaps_from_separation(count, order, separation, normals, gaps):
    """Normal gap and tangential separation (k, 2) of the kept multipliers, nan elsewhere."""
    gaps[:] = np.nan
    for i in range(count):
        k = order[i]
        x, y = separation[k, 0], separation[k, 1]
        gaps[k, 0] = normals[k, 0] * x + normals[k, 1] * y
        gaps[k, 1] = normals[k, 1] * x - normals[k, 0] * y
