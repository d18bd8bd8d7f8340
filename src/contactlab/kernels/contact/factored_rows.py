"""Constraints of a pair as columns of D and M and the coupling T, without the rows T^-T [D^T | -M^T].

A row extends along the whole contact, a column over the few nodes that share a segment with its multiplier.
Columns and two substitutions with T replace all products with rows in O(constraints).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.pair import PairTable


@kernel
def allow_constant_motion(count, rows, current, predicted, velocity, last_dt, offset):
    """Replace initial gaps by the constraint at the end of the step, as `allow_motion` does for written rows.

    The first `count` of `rows`, `FactoredRows`, are in use; offset (k,) [mm] becomes the gap at the start plus the
    allowed motion.
    """
    carried, (px, py, qx, qy) = np.empty((count, 4)), (0.0, 0.0, 0.0, 0.0)
    for i in range(count):
        x, y, s, t = 0.0, 0.0, 0.0, 0.0
        for z in range(rows.start[i], rows.start[i + 1]):
            n, w = rows.node[z], rows.weight[z]
            x, y = x + w * (predicted[n, 0] - current[n, 0]), y + w * (predicted[n, 1] - current[n, 1])
            s, t = s + w * velocity[n, 0], t + w * velocity[n, 1]
        u, v = rows.inverse[i], -rows.above[i] * rows.inverse[i]
        px, py, qx, qy = v * px + u * x, v * py + u * y, v * qx + u * s, v * qy + u * t
        carried[i, 0], carried[i, 1], carried[i, 2], carried[i, 3] = px, py, qx, qy
    px, py, qx, qy, factor = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(count - 1, -1, -1):
        v, n = -factor * rows.inverse[i], rows.own[i]
        px, py, qx, qy = v * px + carried[i, 0], v * py + carried[i, 1], v * qx + carried[i, 2], v * qy + carried[i, 3]
        x, y, s, t = px, py, qx, qy
        if n >= 0:
            x, y = x + (predicted[n, 0] - current[n, 0]), y + (predicted[n, 1] - current[n, 1])
            s, t = s + velocity[n, 0], t + velocity[n, 1]
        moved = rows.normal[i, 0] * x + rows.normal[i, 1] * y
        came = last_dt * (rows.normal[i, 0] * s + rows.normal[i, 1] * t)
        allowed = min(-rows.gap[i], -came, 0.0)
        offset[i] = rows.gap[i] + allowed
        rows.gap[i] = moved - allowed
        factor = rows.below[i]


@section
def _write_column(k, column, sign, numbers, at, node, weight):
    start, end, values = column.start, column.end, column.weight
    for z in range(start[k], end[k]):
        w = values[k, z - start[k]]
        if w != 0.0:
            node[at], weight[at] = numbers[z], sign * w
            at += 1
    return at


@kernel
def write_factored(bound, first_slot, row, out):
    """Append all constraints of a pair to the `row` rows of the model. Return their number, or -1 if out of room.

    bound  address of a `PairTable`
    out    `FactoredRows` of the model
    """
    pair = unpack(bound, PairTable)
    c, columns, slave, master = pair.coupling, pair.columns, pair.places.slave, pair.places.master
    single, normal, gaps = c.single[0], pair.pieces.normal, pair.gaps
    at = out.start[row]
    for i in range(c.kept[0]):
        k = c.order[i]
        room = columns.master.end[k] - columns.master.start[k]
        room += 0 if single else columns.slave.end[k] - columns.slave.start[k]
        if row >= out.gap.size or at + max(room, 0) > out.node.size:
            return -1
        at = _write_column(k, columns.master, -1.0, master, at, out.node, out.weight)
        if not single:
            at = _write_column(k, columns.slave, 1.0, slave, at, out.node, out.weight)
        p = c.previous[k]
        out.own[row] = slave[k % slave.size] if single else -1
        out.normal[row, 0], out.normal[row, 1] = normal[k, 0], normal[k, 1]
        out.gap[row], out.size[row], out.slot[row] = gaps[k, 0], c.full[k], first_slot + k
        out.above[row], out.below[row] = (c.upper[p], c.lower[k]) if p >= 0 else (0.0, 0.0)
        out.inverse[row] = 1.0 / c.pivot[k]
        row += 1
        out.start[row] = at
    return row
