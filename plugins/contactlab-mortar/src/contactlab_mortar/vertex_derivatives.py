"""Derivatives of the normals at ends and vertices: what `vertices` does, differentiated.

n = u/|u| with u = (1 - s) a + s f: a the averaged normal, f the unit vector of the master's summed normals F, and
s = R(t - p (1 - w)) the share, at ends times R(c^2/(b + 4 (1 - w) + l)): c = a x f, t and b the squared sines by which
the slave turns at the node and beside it, w = |F|^2/W^2 with the length W seen of the master.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.tables import DerivativesTable
from contactlab_mortar.vertices import LEAN, SPREAD, TURN, beside_end, facing_sums, is_end, lean_ratio, ramp, turn


@point
def _ramp_derivative(value, low, high):
    t = (value - low) / (high - low)
    return 6.0 * t * (1.0 - t) / (high - low) if 0.0 < t < 1.0 else 0.0


@section
def _state(k, a, sums, sides, out):
    """What the derivatives of multiplier k need into out[k] (12,), zeros where its normal is the averaged one.

    out[k] = s, ds/dc, ds/dt, ds/db, ds/dw, f, |F|, n, 1/|u|, W
    """
    size, chain = np.sqrt(sums[k, 0] * sums[k, 0] + sums[k, 1] * sums[k, 1]), sides.slave.node_segments
    if size == 0.0:
        return
    seen, fx, fy = (size / sums[k, 2]) ** 2, sums[k, 0] / size, sums[k, 1] / size
    more = turn(k, sides.slave_at, sides.slave.segments, chain) - SPREAD * (1.0 - seen)
    cross, bend, lean, leans, free = a[k, 0] * fy - a[k, 1] * fx, ramp(more, TURN[0], TURN[1]), 1.0, 0.0, 1.0
    if is_end(k, chain):
        ratio, free = lean_ratio(k, cross, seen, sides.slave_at, sides.slave.segments, chain)
        lean, leans = ramp(ratio, LEAN[0], LEAN[1]), bend * _ramp_derivative(ratio, LEAN[0], LEAN[1])
    share = lean * bend
    if share > 0.0:
        turns, freed = lean * _ramp_derivative(more, TURN[0], TURN[1]), leans * (cross / free) ** 2
        ux, uy = a[k, 0] + share * (fx - a[k, 0]), a[k, 1] + share * (fy - a[k, 1])
        length = np.sqrt(ux * ux + uy * uy)
        out[k, 0], out[k, 1], out[k, 2] = share, leans * 2.0 * cross / free, turns
        out[k, 3], out[k, 4] = -freed, 4.0 * freed + SPREAD * turns
        out[k, 5], out[k, 6], out[k, 7] = fx, fy, size
        out[k, 8], out[k, 9], out[k, 10], out[k, 11] = ux / length, uy / length, 1.0 / length, sums[k, 2]


@section
def _put(at, k, moved, state, averaged, change, out):
    """Entry `at`: what a change (2,) of the averaged normal, of the sum F or of a turn of node k does to n.

    change = which of these: 0, 1, or 2 and 3 for the turns t and b; x, y, and that of the length W
    """
    which, x, y, longer = change
    fx, fy, ax, ay = state[k, 5], state[k, 6], averaged[k, 0], averaged[k, 1]
    dx, dy = fx - ax, fy - ay
    if which == 0:
        grown = state[k, 1] * (x * fy - y * fx)
        x, y = (1.0 - state[k, 0]) * x + grown * dx, (1.0 - state[k, 0]) * y + grown * dy
    elif which == 1:
        along, size, whole = x * fx + y * fy, state[k, 7], state[k, 11]
        seen = 2.0 * size / (whole * whole) * (along - longer * size / whole)
        x, y = (x - along * fx) / size, (y - along * fy) / size
        grown = state[k, 1] * (ax * y - ay * x) + state[k, 4] * seen
        x, y = state[k, 0] * x + grown * dx, state[k, 0] * y + grown * dy
    else:
        grown = state[k, which] * x
        x, y = grown * dx, grown * dy
    along = x * state[k, 8] + y * state[k, 9]
    out.normal_of[at], out.normal_moved[at] = k, moved
    out.dnormal[at, 0] = (x - along * state[k, 8]) * state[k, 10]
    out.dnormal[at, 1] = (y - along * state[k, 9]) * state[k, 10]
    return at + 1


@point
def _master_normal(master, p, master_at):
    """Outward unit normal of the edge of entry p of master nodes, and its length [mm]."""
    c, d = master[p, 0], master[p, 1]
    x, y = master_at[d, 1] - master_at[c, 1], master_at[c, 0] - master_at[d, 0]
    size = np.sqrt(x * x + y * y)
    return x / size, y / size, size


@section
def _by_lengths(table, count, state, at):
    """Entries of the lengths over which multipliers see each edge of the master: those that `count` changes have."""
    out = table.out
    for e in range(count):
        for j in range(2):
            k = out.multiplier[e, j]
            if state[k, 0] != 0.0:
                x, y, _ = _master_normal(out.master, e, table.sides.master_at)
                weight = out.dT[e, 0, j] + out.dT[e, 1, j]
                at = _put(at, k, out.moved[e], state, table.averaged, (1, weight * x, weight * y, weight), out)
    return at


@section
def _by_master_normals(table, count, state, at):
    """Entries of the normals of the master's edges, by both ends of each."""
    pieces, sides = table.pieces, table.sides
    for p in range(count):
        for j in range(2):
            k = pieces.multiplier[p, j]
            if state[k, 0] == 0.0:
                continue
            nx, ny, size = _master_normal(pieces.master, p, sides.master_at)
            weight = (pieces.T[p, 0, j] + pieces.T[p, 1, j]) / size
            for end in range(2):
                for direction in range(2):
                    # the edge vector (x, y) turned by -90 degrees is (y, -x)
                    sign = weight if end == 1 else -weight
                    x, y = (0.0, -sign) if direction == 0 else (sign, 0.0)
                    along = x * nx + y * ny
                    moved = 2 * (sides.slave_at.shape[0] + pieces.master[p, end]) + direction
                    at = _put(at, k, moved, state, table.averaged, (1, x - along * nx, y - along * ny, 0.0), table.out)
    return at


@section
def _by_turn(table, k, j, which, state, at):
    """Entries of the turn at node j, an inner one, by its own place and those of its neighbours."""
    slave_at, slave = table.sides.slave_at, table.sides.slave
    before, after = slave.segments[slave.node_segments[j, 0], 0], slave.segments[slave.node_segments[j, 1], 1]
    ex, ey = slave_at[j, 0] - slave_at[before, 0], slave_at[j, 1] - slave_at[before, 1]
    gx, gy = slave_at[after, 0] - slave_at[j, 0], slave_at[after, 1] - slave_at[j, 1]
    e2, g2, cross = ex * ex + ey * ey, gx * gx + gy * gy, ex * gy - ey * gx
    if ex * gx + ey * gy <= 0.0:
        return at
    for place in range(3):
        node = before if place == 0 else (j if place == 1 else after)
        de = -1.0 if place == 0 else (1.0 if place == 1 else 0.0)
        dg = 0.0 if place == 0 else (-1.0 if place == 1 else 1.0)
        for direction in range(2):
            own, other = (ex, gx) if direction == 0 else (ey, gy)
            turned = de * gy - dg * ey if direction == 0 else dg * ex - de * gx
            change = 2.0 * cross / (e2 * g2) * (turned - cross * (own * de / e2 + other * dg / g2))
            at = _put(at, k, 2 * node + direction, state, table.averaged, (which, change, 0.0, 0.0), table.out)
    return at


@kernel
def vertex_derivatives(bound, count, changes, given):
    """Mend and add to the `given` derivatives of averaged normals; returns the number of entries.

    `bound` is the address of a `DerivativesTable` with `count` pieces and `changes` derivatives of them.
    """
    table = unpack(bound, DerivativesTable)
    pieces, sides, averaged, out = table.pieces, table.sides, table.averaged, table.out
    m, at = averaged.shape[0], given
    slave = sides.slave
    sums, state = np.empty((m, 3)), np.zeros((m, 12))
    facing_sums(count, pieces.multiplier, pieces.master, pieces.T, sides.master_at, np.ones(m), sums)
    for k in range(m):
        _state(k, averaged, sums, sides, state)
    for e in range(given):
        k = out.normal_of[e]
        if state[k, 0] != 0.0:
            _put(e, k, out.normal_moved[e], state, averaged, (0, out.dnormal[e, 0], out.dnormal[e, 1], 0.0), out)
    at = _by_lengths(table, changes, state, at)
    at = _by_master_normals(table, count, state, at)
    for k in range(m):
        if state[k, 0] == 0.0:
            continue
        if not is_end(k, slave.node_segments):
            at = _by_turn(table, k, k, 2, state, at)
        elif beside_end(k, slave.segments, slave.node_segments) >= 0:
            at = _by_turn(table, k, beside_end(k, slave.segments, slave.node_segments), 3, state, at)
    return at
