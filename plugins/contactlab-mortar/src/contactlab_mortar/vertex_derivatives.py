"""Derivatives of the normals at vertices: what `vertices` does, differentiated.

n = u/|u| with u = (1 - s) a + s f: a the averaged normal, f the unit vector of the master's summed normals F, and
s = R(|a x f|) R(t) the share, t being the turn of the slave.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point
from contactlab_mortar.vertices import LEAN, TURN, _ramp, facing_sums, slave_turn


@point
def _ramp_derivative(value, low, high):
    t = (value - low) / (high - low)
    return 6.0 * t * (1.0 - t) / (high - low) if 0.0 < t < 1.0 else 0.0


@kernel
def _state(k, a, sums, turn, out):
    """What the derivatives of multiplier k need into out (9,); False where its normal is the averaged one.

    out = s, R(turn) R'(lean) with the sign of a x f, R(lean) R'(turn), f, |F|, n, 1/|u|
    """
    size = np.sqrt(sums[k, 0] * sums[k, 0] + sums[k, 1] * sums[k, 1])
    if size == 0.0:
        return False
    fx, fy = sums[k, 0] / size, sums[k, 1] / size
    cross = a[k, 0] * fy - a[k, 1] * fx
    lean, bend = _ramp(abs(cross), LEAN[0], LEAN[1]), _ramp(turn, TURN[0], TURN[1])
    share = lean * bend
    if share == 0.0:
        return False
    ux, uy = a[k, 0] + share * (fx - a[k, 0]), a[k, 1] + share * (fy - a[k, 1])
    length = np.sqrt(ux * ux + uy * uy)
    out[0] = share
    out[1] = bend * _ramp_derivative(abs(cross), LEAN[0], LEAN[1]) * np.copysign(1.0, cross)
    out[2] = lean * _ramp_derivative(turn, TURN[0], TURN[1])
    out[3], out[4], out[5] = fx, fy, size
    out[6], out[7], out[8] = ux / length, uy / length, 1.0 / length
    return True


@kernel
def _put(at, k, moved, state, a, change, kind, normal_of, normal_moved, dnormal):
    """Entry `at`: what a change of the averaged normal (0), of the sum F (1) or of the turn (2) does to n."""
    x, y, fx, fy = change[0], change[1], state[3], state[4]
    dx, dy = fx - a[k, 0], fy - a[k, 1]
    if kind == 0:
        grown = state[1] * (x * fy - y * fx)
        x, y = (1.0 - state[0]) * x + grown * dx, (1.0 - state[0]) * y + grown * dy
    elif kind == 1:
        along = x * fx + y * fy
        x, y = (x - along * fx) / state[5], (y - along * fy) / state[5]
        grown = state[1] * (a[k, 0] * y - a[k, 1] * x)
        x, y = state[0] * x + grown * dx, state[0] * y + grown * dy
    else:
        x, y = state[2] * change[0] * dx, state[2] * change[0] * dy
    along = x * state[6] + y * state[7]
    normal_of[at], normal_moved[at] = k, moved
    dnormal[at, 0], dnormal[at, 1] = (x - along * state[6]) * state[8], (y - along * state[7]) * state[8]


@kernel
def _master_normal(nodes, p, master_at, out):
    """Outward unit normal of the edge of piece p into out (2,); returns its length [mm]."""
    c, d = master_at[nodes[p, 0]], master_at[nodes[p, 1]]
    x, y = d[1] - c[1], c[0] - d[0]
    size = np.sqrt(x * x + y * y)
    out[0], out[1] = x / size, y / size
    return size


@kernel
def vertex_derivatives(pieces, entries, slave, slave_at, master_at, averaged, given, normals):
    """Mend and add to the `given` derivatives of averaged normals (m, 2); returns the number of entries.

    pieces = (count, multipliers, master nodes, T)
    entries = (count, multiplier, master, moved, dT) of `mortar_derivatives`
    slave = (segments, node_segments), normals = (normal_of, normal_moved, dnormal)
    """
    count, multiplier, master_nodes, T = pieces
    entry_count, e_multiplier, e_master, e_moved, dT = entries
    segments, node_segments = slave
    normal_of, normal_moved, dnormal = normals
    m, at = averaged.shape[0], given
    sums, state, turned = np.empty((m, 2)), np.empty((m, 9)), np.zeros(m, np.bool_)
    facing_sums(count, multiplier, master_nodes, T, master_at, np.ones(sums.shape[0]), sums)
    for k in range(m):
        turned[k] = _state(k, averaged, sums, slave_turn(k, slave_at, segments, node_segments), state[k])
    change, normal = np.empty(2), np.empty(2)
    for e in range(given):
        k = normal_of[e]
        if turned[k]:
            change[0], change[1] = dnormal[e, 0], dnormal[e, 1]
            _put(e, k, normal_moved[e], state[k], averaged, change, 0, normal_of, normal_moved, dnormal)
    for e in range(entry_count):
        for j in range(2):
            k = e_multiplier[e, j]
            if turned[k]:
                _master_normal(e_master, e, master_at, normal)
                weight = dT[e, 0, j] + dT[e, 1, j]
                change[0], change[1] = weight * normal[0], weight * normal[1]
                _put(at, k, e_moved[e], state[k], averaged, change, 1, normal_of, normal_moved, dnormal)
                at += 1
    for p in range(count):
        for j in range(2):
            k = multiplier[p, j]
            if not turned[k]:
                continue
            size = _master_normal(master_nodes, p, master_at, normal)
            weight = (T[p, 0, j] + T[p, 1, j]) / size
            for end in range(2):
                for direction in range(2):
                    # the edge vector (x, y) turned by -90 degrees is (y, -x)
                    sign = weight if end == 1 else -weight
                    x, y = (0.0, -sign) if direction == 0 else (sign, 0.0)
                    along = x * normal[0] + y * normal[1]
                    change[0], change[1] = x - along * normal[0], y - along * normal[1]
                    moved = 2 * (slave_at.shape[0] + master_nodes[p, end]) + direction
                    _put(at, k, moved, state[k], averaged, change, 1, normal_of, normal_moved, dnormal)
                    at += 1
    for k in range(m):
        if turned[k] and state[k, 2] != 0.0:
            at = _turn_derivatives(at, k, state, averaged, slave_at, segments, node_segments, normals)
    return at


@kernel
def _turn_derivatives(at, k, state, averaged, slave_at, segments, node_segments, normals):
    """Entries of the turn at node k, an inner one, by its own place and those of its neighbours."""
    normal_of, normal_moved, dnormal = normals
    before, after = segments[node_segments[k, 0], 0], segments[node_segments[k, 1], 1]
    ex, ey = slave_at[k, 0] - slave_at[before, 0], slave_at[k, 1] - slave_at[before, 1]
    gx, gy = slave_at[after, 0] - slave_at[k, 0], slave_at[after, 1] - slave_at[k, 1]
    e2, g2, cross = ex * ex + ey * ey, gx * gx + gy * gy, ex * gy - ey * gx
    scale, sign = 1.0 / np.sqrt(e2 * g2), np.copysign(1.0, cross)
    change = np.empty(2)
    for which in range(3):
        node = before if which == 0 else (k if which == 1 else after)
        de = -1.0 if which == 0 else (1.0 if which == 1 else 0.0)
        dg = 0.0 if which == 0 else (-1.0 if which == 1 else 1.0)
        for direction in range(2):
            own, other = (ex, gx) if direction == 0 else (ey, gy)
            turned = de * gy - dg * ey if direction == 0 else dg * ex - de * gx
            change[0] = sign * scale * (turned - cross * (own * de / e2 + other * dg / g2))
            change[1] = 0.0
            _put(at, k, 2 * node + direction, state[k], averaged, change, 2, normal_of, normal_moved, dnormal)
            at += 1
    return at
