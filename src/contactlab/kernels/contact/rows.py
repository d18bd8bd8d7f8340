"""Sparse gap rows G = T^-T [D^T | -M^T] . normal, written out from the windows of a pair."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section


@section
def _write(k, side, sign, numbers, normal, at, node, normal_weight, tangent_weight):
    """Entries of one side of condition k; returns the next free entry."""
    start, end, weight = side
    nx, ny = sign * normal[0], sign * normal[1]
    shift = start[k]
    for z in range(start[k], end[k]):
        w = weight[k, z - shift]
        if w == 0.0:
            continue
        node[at] = numbers[z]
        normal_weight[at, 0], normal_weight[at, 1] = w * nx, w * ny
        if tangent_weight.shape[0] > 0:
            tangent_weight[at, 0], tangent_weight[at, 1] = w * ny, -w * nx
        at += 1
    return at


@kernel
def write_rows(
    count, order, multipliers, margin, slave, master, slave_nodes, master_nodes, normals, gaps, cover, sizes,
    first_slot, row, at, out,
):  # fmt: skip
    """Append the conditions with a gap below `margin` or a force; returns (rows, entries), (-1, 0) if out of room.

    out = (start, node, normal_weight, tangent_weight, gap, measure, size, slot) of the model's rows
    """
    start, node, normal_weight, tangent_weight, gap, measure, size, slot = out
    for i in range(count):
        k = order[i]
        if gaps[k, 0] >= margin and multipliers[0, first_slot + k] <= 0.0:
            continue
        room = slave[1][k] - slave[0][k] + master[1][k] - master[0][k]
        if row >= gap.size or at + room > node.size:
            return -1, 0
        start[row] = at
        at = _write(k, slave, 1.0, slave_nodes, normals[k], at, node, normal_weight, tangent_weight)
        at = _write(k, master, -1.0, master_nodes, normals[k], at, node, normal_weight, tangent_weight)
        start[row + 1] = at
        gap[row], measure[row], size[row] = gaps[k, 0], cover[k], sizes[k]
        slot[row] = first_slot + k
        row += 1
    return row, at


@kernel
def write_slips(first, last, first_slot, start, node, tangent_weight, slot, gaps, normals, before, current, slip):
    """Slip of the step in rows first ... last - 1: tangent times separation now minus at its start.

    Each term has the tangent of its own time and both have the same weights (docs/theory/rows.md), so that a
    rigid rotation of the pair gives none. `before` (k, 2) are the normals and `current` (N, 2) the
    positions at the start of the step.
    """
    for row in range(first, last):
        k = slot[row] - first_slot
        # tangent = (ny, -nx): the scalar weight is tangent . tangent_weight
        tx, ty = normals[k, 1], -normals[k, 0]
        x, y = 0.0, 0.0
        for z in range(start[row], start[row + 1]):
            w = tangent_weight[z, 0] * tx + tangent_weight[z, 1] * ty
            x += w * current[node[z], 0]
            y += w * current[node[z], 1]
        slip[row] = gaps[k, 1] - (before[k, 1] * x - before[k, 0] * y)


@kernel
def tangential_work(
    count, start, node, tangent_weight, slot, multipliers, slip, mean_velocity, dt, compliance, force
):  # fmt: skip
    """Sum over the rows of y_t times mean sliding velocity times dt, and of -y_t times the slip at the end."""
    work, dissipated = 0.0, 0.0
    for row in range(count):
        y = multipliers[1, slot[row]]
        if y == 0.0:
            continue
        sliding, end = 0.0, slip[row]
        for z in range(start[row], start[row + 1]):
            n = node[z]
            tx, ty = tangent_weight[z, 0], tangent_weight[z, 1]
            sliding += tx * mean_velocity[n, 0] + ty * mean_velocity[n, 1]
            end += tx * compliance[n, 0] * force[n, 0] + ty * compliance[n, 1] * force[n, 1]
        work += dt * y * sliding
        dissipated -= y * end
    return work, dissipated
