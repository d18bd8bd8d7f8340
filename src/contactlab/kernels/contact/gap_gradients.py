"""Rows of consistent forces: gaps differentiated by all that they depend on, G = dg/dx.

Row k of G is normal . T^-T [D^T - M^T + dW] + separation . d(normal)/dx. A frozen row lacks the last two
parts: weights that change as surfaces slide along each other, and normals that turn (docs/theory/contact-energy.md).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.pair import PairTable
from contactlab.kernels.contact.weights import CUT, weighted_change


@section
def _number(nodes, count, shift, place, size):
    """Number the nodes of the first `count` rows of nodes (p, v) that have no number yet. Return the total."""
    for p in range(count):
        for i in range(nodes.shape[1]):
            v = shift + nodes[p, i]
            if nodes[p, i] >= 0 and place[v] < 0:
                place[v] = size
                size += 1
    return size


@section
def _touched(pair, gradients, used, row_of, place):
    """Number in place (m + l,) all nodes of the kept constraints, -1 elsewhere. Return the global nodes."""
    m, count = pair.places.slave.size, used[0]
    size = _number(pair.pieces.slave, count, 0, place, 0)
    size = _number(pair.pieces.master, count, m, place, size)
    size = _number(gradients.node, used[1], 0, place, size)
    for e in range(used[2]):
        v = gradients.normal_moved[e] // 2
        if row_of[gradients.normal_of[e]] >= 0 and place[v] < 0:
            place[v] = size
            size += 1
    node_of = np.empty(size, np.int32)
    for v in range(place.size):
        if place[v] >= 0:
            node_of[place[v]] = pair.places.slave[v] if v < m else pair.places.master[v - m]
    return node_of


@section
def _put_columns(i, columns, k, sign, shift, place, P):
    """Write weights of one side of constraint i: sign times column k of D or M."""
    start = columns.start[k]
    for z in range(start, columns.end[k]):
        weight = columns.weight[k, z - start]
        if weight != 0.0:
            P[i, place[shift + z]] += sign * weight


@section
def _put_gradients(gradients, entries, owner, row_of, place, W):
    """Write derivatives of the weighted separations by the changes of weights."""
    multiplier, node, value = gradients.multiplier, gradients.node, gradients.value
    for p in range(entries):
        for j in range(multiplier.shape[1]):
            k = owner[multiplier[p, j]]
            i = row_of[k] if k >= 0 else -1
            if i < 0:
                continue
            for v in range(node.shape[1]):
                if node[p, v] < 0:
                    continue
                at = 2 * place[node[p, v]]
                for c in range(2):
                    W[i, c, at] += value[p, j, c, v, 0]
                    W[i, c, at + 1] += value[p, j, c, v, 1]


@section
def _weights(pair, gradients, entries, row_of, place, P, W):
    """Write D^T - M^T of the constraints into P (k, nodes), and their changes into W (k, 2, dof)."""
    c, m = pair.coupling, pair.places.slave.size
    for i in range(P.shape[0]):
        k = c.order[i]
        if not pair.coupling.single[0]:
            _put_columns(i, pair.columns.slave, k, 1.0, 0, place, P)
        _put_columns(i, pair.columns.master, k, -1.0, m, place, P)
        for n in range(P.shape[1]):
            W[i, 0, 2 * n] = P[i, n]
            W[i, 1, 2 * n + 1] = P[i, n]
    _put_gradients(gradients, entries, c.owner, row_of, place, W)


@section
def _solve(c, W):
    """Overwrite W (k, columns) by T^-T W; coupled constraints follow one another."""
    for i in range(W.shape[0]):
        k = c.order[i]
        scale = 1.0 / c.pivot[k]
        factor = scale * c.upper[c.previous[k]] if c.previous[k] >= 0 else 0.0
        row, before = W[i], W[max(i - 1, 0)]
        for z in range(row.size):
            row[z] = scale * row[z] - factor * before[z]
    for i in range(W.shape[0] - 2, -1, -1):
        k = c.order[i]
        if c.next[k] < 0:
            continue
        factor = c.lower[c.next[k]] / c.pivot[k]
        row, after = W[i], W[i + 1]
        for z in range(row.size):
            row[z] -= factor * after[z]


@section
def _turning(gradients, count, separation, row_of, place, across, along):
    """Add separation . d(normal)/dx, and for tangents if `along` has rows, by degrees of freedom."""
    for e in range(count):
        k = gradients.normal_of[e]
        i = row_of[k]
        if i < 0:
            continue
        moved = gradients.normal_moved[e]
        at = 2 * place[moved // 2] + moved % 2
        x, y = gradients.dnormal[e, 0], gradients.dnormal[e, 1]
        across[i, at] += separation[k, 0] * x + separation[k, 1] * y
        if along.shape[0] > 0:
            along[i, at] += separation[k, 0] * y - separation[k, 1] * x


@section
def _entries(P, W, across, along, normal, node_of, at, rows):
    """Write entries of one constraint from `at` on. Return the next free entry.

    Slip is the motion of a point of the slave along its present point of the master, with frozen weights.
    """
    nx, ny = normal[0], normal[1]
    across_of, slip_of, friction = rows.normal_weight, rows.tangent_weight, along.shape[0] > 0
    for n in range(node_of.size):
        x, y = 2 * n, 2 * n + 1
        across_of[at, 0] = nx * W[0, x] + ny * W[1, x] + across[x]
        across_of[at, 1] = nx * W[0, y] + ny * W[1, y] + across[y]
        found = abs(across_of[at, 0]) > CUT or abs(across_of[at, 1]) > CUT
        if friction:
            slip_of[at, 0], slip_of[at, 1] = ny * P[n] + along[0, x], along[0, y] - nx * P[n]
            found = found or abs(slip_of[at, 0]) > CUT or abs(slip_of[at, 1]) > CUT
        if found:
            rows.node[at] = node_of[n]
            at += 1
    return at


@kernel
def write_rows(bound, gradients, used, margin, multipliers, first_slot, ends, rows):
    """Append constraints with a gap below `margin` or a force. Return (rows, entries), or (-1, 0) if out of room.

    bound      address of a `PairTable`
    gradients  `GapGradients`; rows: the model's `Rows`
    used       pieces, gradients and derivatives of normals in use
    ends       rows and entries that are in use already
    """
    pair = unpack(bound, PairTable)
    c, kept, friction = pair.coupling, pair.coupling.kept[0], rows.tangent_weight.shape[0] > 0
    m, (row, at) = pair.places.slave.size, ends
    row_of, place = np.full(c.owner.size, -1, np.int32), np.full(m + pair.places.master.size, -1, np.int32)
    for i in range(kept):
        row_of[c.order[i]] = i
    node_of = _touched(pair, gradients, used, row_of, place)
    size = node_of.size
    P, W, across = np.zeros((kept, size)), np.zeros((kept, 2, 2 * size)), np.zeros((kept, 2 * size))
    along = np.zeros((kept if friction else 0, 2 * size))
    _weights(pair, gradients, used[1], row_of, place, P, W)
    _solve(c, W.reshape(kept, 4 * size))
    if friction:
        _solve(c, P)
    _turning(gradients, used[2], pair.separation, row_of, place, across, along)
    for i in range(kept):
        k = c.order[i]
        if pair.gaps[k, 0] >= margin and multipliers[0, first_slot + k] <= 0.0:
            continue
        if row >= rows.gap.size or at + size > rows.node.size:
            return -1, 0
        if pair.coupling.single[0]:
            own = place[k % m]
            W[i, 0, 2 * own] += 1.0
            W[i, 1, 2 * own + 1] += 1.0
            P[i, own] += 1.0
        rows.start[row] = at
        at = _entries(P[i], W[i], across[i], along[i if friction else 0 :], pair.pieces.normal[k], node_of, at, rows)
        rows.start[row + 1] = at
        rows.gap[row], rows.measure[row], rows.size[row] = pair.gaps[k, 0], c.cover[k], c.full[k]
        rows.slot[row] = first_slot + k
        row += 1
    return row, at


@kernel
def allow_motion(first, last, rows, current, predicted, velocity, last_dt, strict):
    """Replace initial gaps of the rows first ... last - 1 by the constraint at the end of the step.

    A force may act only as far as the surfaces end up no closer than they were one step before, and after they have
    met, no closer than now: the gap becomes the predicted motion less this bound (docs/theory/contact-energy.md);
    without `strict` the predicted gap.
    """
    for row in range(first, last):
        moved, came, at, slid = 0.0, 0.0, 0.0, 0.0
        for z in range(rows.start[row], rows.start[row + 1]):
            n = rows.node[z]
            for c in range(2):
                w = rows.normal_weight[z, c]
                step = predicted[n, c] - current[n, c]
                moved += w * step
                came += w * velocity[n, c]
                at += w * current[n, c]
                if rows.slip.size > 0:
                    slid += rows.tangent_weight[z, c] * step
        rows.offset[row] = rows.gap[row] - at
        allowed = -rows.gap[row]
        if strict:
            allowed = min(allowed, -last_dt * came, 0.0)
        rows.gap[row] = moved - allowed
        if rows.slip.size > 0:
            rows.slip[row] = slid


@kernel
def from_derivatives(count, derivatives, owner, at, separation, out):
    """Convert derivatives of pieces by coordinates to gradients with one node each. Return their number.

    derivatives = (slave, multiplier, master, moved, dD, dM, dT), at = positions of slave and master,
    out = (multiplier, node, value)
    """
    multiplier, moved = derivatives[1], derivatives[3]
    o_multiplier, node, value = out
    for e in range(count):
        node[e, 0] = moved[e] // 2
        for j in range(multiplier.shape[1]):
            o_multiplier[e, j] = multiplier[e, j]
            for c in range(2):
                value[e, j, c, 0, 0], value[e, j, c, 0, 1] = 0.0, 0.0
                value[e, j, c, 0, moved[e] % 2] = weighted_change(e, j, c, derivatives, owner, at, separation)
    return count


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


@kernel
def largest_sideways(bound):
    """Return the largest offset across the normal between joined points, over the length of their slave segments.

    `bound` is the address of a `PairTable`, with gaps at the positions of the constraints.
    """
    pair = unpack(bound, PairTable)
    c, largest = pair.coupling, 0.0
    for i in range(c.kept[0]):
        k = c.order[i]
        largest = max(largest, abs(pair.gaps[k, 1]) / c.full[k])
    return largest
