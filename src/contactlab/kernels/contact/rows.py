"""Sparse gap rows G = T^-T [D^T | -M^T] . normal, written out from the banded rows of a pair."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.pair import PairTable


@section
def _write(k, side, sign, numbers, normal, at, rows):
    """Write entries of one side of constraint k. Return the next free entry."""
    start, end, weight = side.start, side.end, side.weight
    nx, ny = sign * normal[0], sign * normal[1]
    shift = start[k]
    for z in range(start[k], end[k]):
        w = weight[k, z - shift]
        if w == 0.0:
            continue
        rows.node[at] = numbers[z]
        rows.normal_weight[at, 0], rows.normal_weight[at, 1] = w * nx, w * ny
        if rows.tangent_weight.shape[0] > 0:
            rows.tangent_weight[at, 0], rows.tangent_weight[at, 1] = w * ny, -w * nx
        at += 1
    return at


@kernel
def write_rows(bound, margin, multipliers, first_slot, row, at, rows):
    """Append constraints with a gap below `margin` or a force. Return (rows, entries), or (-1, 0) if out of room.

    bound  address of a `PairTable`
    rows   the model's `Rows`, of which `row` rows and `at` entries are in use
    """
    pair = unpack(bound, PairTable)
    c, gaps, normal = pair.coupling, pair.gaps, pair.pieces.normal
    slave, master = pair.weights.slave, pair.weights.master
    for i in range(c.kept[0]):
        k = c.order[i]
        if gaps[k, 0] >= margin and multipliers[0, first_slot + k] <= 0.0:
            continue
        room = slave.end[k] - slave.start[k] + master.end[k] - master.start[k]
        if row >= rows.gap.size or at + room > rows.node.size:
            return -1, 0
        rows.start[row] = at
        at = _write(k, slave, 1.0, pair.places.slave, normal[k], at, rows)
        at = _write(k, master, -1.0, pair.places.master, normal[k], at, rows)
        rows.start[row + 1] = at
        rows.gap[row], rows.measure[row], rows.size[row] = gaps[k, 0], c.cover[k], c.full[k]
        rows.slot[row] = first_slot + k
        row += 1
    return row, at


@kernel
def write_slips(first, last, first_slot, measured, current, rows):
    """Compute the slip of the step in rows first ... last - 1: tangent times separation now minus at the start.

    Each term has the tangent of its own time and both have the same weights (docs/theory/rows.md), so that a
    rigid rotation of the pair gives none. measured = gaps, normals and the normals at the start of the step, (k, 2)
    each; `current` (N, 2) are the positions at the start of the step.
    """
    gaps, normals, before = measured
    for row in range(first, last):
        k = rows.slot[row] - first_slot
        # tangent = (ny, -nx): the scalar weight is tangent . tangent_weight
        tx, ty = normals[k, 1], -normals[k, 0]
        x, y = 0.0, 0.0
        for z in range(rows.start[row], rows.start[row + 1]):
            w = rows.tangent_weight[z, 0] * tx + rows.tangent_weight[z, 1] * ty
            x += w * current[rows.node[z], 0]
            y += w * current[rows.node[z], 1]
        rows.slip[row] = gaps[k, 1] - (before[k, 1] * x - before[k, 0] * y)


@kernel
def tangential_work(count, rows, multipliers, mean_velocity, dt, compliance, force):
    """Return sums over the rows of y_t times mean sliding velocity times dt, and of -y_t times the slip at the end."""
    work, dissipated = 0.0, 0.0
    for row in range(count):
        y = multipliers[1, rows.slot[row]]
        if y == 0.0:
            continue
        sliding, end = 0.0, rows.slip[row]
        for z in range(rows.start[row], rows.start[row + 1]):
            n = rows.node[z]
            tx, ty = rows.tangent_weight[z, 0], rows.tangent_weight[z, 1]
            sliding += tx * mean_velocity[n, 0] + ty * mean_velocity[n, 1]
            end += tx * compliance[n, 0] * force[n, 0] + ty * compliance[n, 1] * force[n, 1]
        work += dt * y * sliding
        dissipated -= y * end
    return work, dissipated


@kernel
def extrapolate(now, before):
    """Extrapolate linearly forces (k,) that pressed in both last steps, never below zero; `before` becomes `now`."""
    for k in range(now.size):
        last = now[k]
        if last > 0.0 and before[k] > 0.0:
            now[k] = max(2.0 * last - before[k], 0.0)
        before[k] = last
