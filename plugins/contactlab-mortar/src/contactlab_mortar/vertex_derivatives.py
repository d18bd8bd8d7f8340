"""Derivatives of the normals at vertices: what `vertices` does, differentiated.

n = u/|u| with u = (1 - s) a + s f: a the averaged normal, f the unit vector of the master's summed normals F, and
s = R(|a x f|) R(t) the share, t being the turn of the slave.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.tables import DerivativesTable
from contactlab_mortar.vertices import LEAN, TURN, _ramp, facing_sums, slave_turn


@point
def _ramp_derivative(value, low, high):
    t = (value - low) / (high - low)
    return 6.0 * t * (1.0 - t) / (high - low) if 0.0 < t < 1.0 else 0.0


@section
def _state(k, a, sums, turn, out):
    """What the derivatives of multiplier k need into out[k] (9,), zeros where its normal is the averaged one.

    out[k] = s, R(turn) R'(lean) with the sign of a x f, R(lean) R'(turn), f, |F|, n, 1/|u|
    """
    size = np.sqrt(sums[k, 0] * sums[k, 0] + sums[k, 1] * sums[k, 1])
    bend = _ramp(turn, TURN[0], TURN[1])
    if size > 0.0 and bend > 0.0:
        fx, fy = sums[k, 0] / size, sums[k, 1] / size
        cross = a[k, 0] * fy - a[k, 1] * fx
        lean = _ramp(abs(cross), LEAN[0], LEAN[1])
        share = lean * bend
        if share > 0.0:
            ux, uy = a[k, 0] + share * (fx - a[k, 0]), a[k, 1] + share * (fy - a[k, 1])
            length = np.sqrt(ux * ux + uy * uy)
            out[k, 0] = share
            out[k, 1] = bend * _ramp_derivative(abs(cross), LEAN[0], LEAN[1]) * np.copysign(1.0, cross)
            out[k, 2] = lean * _ramp_derivative(turn, TURN[0], TURN[1])
            out[k, 3], out[k, 4], out[k, 5] = fx, fy, size
            out[k, 6], out[k, 7], out[k, 8] = ux / length, uy / length, 1.0 / length


@section
def _put(at, k, moved, state, averaged, change, out):
    """Entry `at`: what a change (2,) of the averaged normal, of the sum F or of the turn of node k does to n.

    change = (which of the three: 0, 1 or 2, x, y)
    """
    which, x, y = change
    fx, fy, ax, ay = state[k, 3], state[k, 4], averaged[k, 0], averaged[k, 1]
    dx, dy = fx - ax, fy - ay
    if which == 0:
        grown = state[k, 1] * (x * fy - y * fx)
        x, y = (1.0 - state[k, 0]) * x + grown * dx, (1.0 - state[k, 0]) * y + grown * dy
    elif which == 1:
        along = x * fx + y * fy
        x, y = (x - along * fx) / state[k, 5], (y - along * fy) / state[k, 5]
        grown = state[k, 1] * (ax * y - ay * x)
        x, y = state[k, 0] * x + grown * dx, state[k, 0] * y + grown * dy
    else:
        x, y = state[k, 2] * x * dx, state[k, 2] * x * dy
    along = x * state[k, 6] + y * state[k, 7]
    out.normal_of[at], out.normal_moved[at] = k, moved
    out.dnormal[at, 0] = (x - along * state[k, 6]) * state[k, 8]
    out.dnormal[at, 1] = (y - along * state[k, 7]) * state[k, 8]


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
                _put(at, k, out.moved[e], state, table.averaged, (1, weight * x, weight * y), out)
                at += 1
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
                    _put(at, k, moved, state, table.averaged, (1, x - along * nx, y - along * ny), table.out)
                    at += 1
    return at


@section
def _by_turn(table, k, state, at):
    """Entries of the turn at node k, an inner one, by its own place and those of its neighbours."""
    slave_at, segments, node_segments = (
        table.sides.slave_at,
        table.sides.slave.segments,
        table.sides.slave.node_segments,
    )
    before, after = segments[node_segments[k, 0], 0], segments[node_segments[k, 1], 1]
    ex, ey = slave_at[k, 0] - slave_at[before, 0], slave_at[k, 1] - slave_at[before, 1]
    gx, gy = slave_at[after, 0] - slave_at[k, 0], slave_at[after, 1] - slave_at[k, 1]
    e2, g2, cross = ex * ex + ey * ey, gx * gx + gy * gy, ex * gy - ey * gx
    scale, sign = 1.0 / np.sqrt(e2 * g2), np.copysign(1.0, cross)
    for which in range(3):
        node = before if which == 0 else (k if which == 1 else after)
        de = -1.0 if which == 0 else (1.0 if which == 1 else 0.0)
        dg = 0.0 if which == 0 else (-1.0 if which == 1 else 1.0)
        for direction in range(2):
            own, other = (ex, gx) if direction == 0 else (ey, gy)
            turned = de * gy - dg * ey if direction == 0 else dg * ex - de * gx
            change = sign * scale * (turned - cross * (own * de / e2 + other * dg / g2))
            _put(at, k, 2 * node + direction, state, table.averaged, (2, change, 0.0), table.out)
            at += 1
    return at


@kernel
def vertex_derivatives(bound, count, changes, given):
    """Mend and add to the `given` derivatives of averaged normals; returns the number of entries.

    `bound` is the address of a `DerivativesTable` with `count` pieces and `changes` derivatives of them.
    """
    table = unpack(bound, DerivativesTable)
    pieces, sides, averaged, out = table.pieces, table.sides, table.averaged, table.out
    m, at = averaged.shape[0], given
    sums, state = np.empty((m, 2)), np.zeros((m, 9))
    facing_sums(count, pieces.multiplier, pieces.master, pieces.T, sides.master_at, np.ones(m), sums)
    for k in range(m):
        turn = slave_turn(k, sides.slave_at, sides.slave.segments, sides.slave.node_segments)
        _state(k, averaged, sums, turn, state)
    for e in range(given):
        k = out.normal_of[e]
        if state[k, 0] != 0.0:
            _put(e, k, out.normal_moved[e], state, averaged, (0, out.dnormal[e, 0], out.dnormal[e, 1]), out)
    at = _by_lengths(table, changes, state, at)
    at = _by_master_normals(table, count, state, at)
    for k in range(m):
        if state[k, 2] != 0.0:
            at = _by_turn(table, k, state, at)
    return at
