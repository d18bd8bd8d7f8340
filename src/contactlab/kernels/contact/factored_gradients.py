"""Rows of conjugate forces before their coupling is inverted: gaps differentiated by all that they depend on.

What changes the weights of a piece is where its points of the master lie. Seen from a fixed place of the slave, one
moves along its segment linearly between the ends of the piece: by beta_e m d(eta_e) for a multiplier, m the segment and
beta_e the integral of psi times the hat of end e. Ends of pieces that follow each other cancel, and so do, where it is
closed, the lengths that a separation is integrated over (docs/theory/contact-energy.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.compiled.bound_arrays import Floats2, Floats3, Ints1, Ints2
from contactlab.api.compiled.contact_tables import FactoredGradientsTable
from contactlab.api.compiled.gradient_products import conditions_moved
from contactlab.api.compiled.kernel import kernel, section, table_kernel
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.tables import PairTable

SHORT = 1e-7  # of a segment: what changes along shorter pieces is below the round-off of where they end


class EndsTable(NamedTuple):
    """What the ends of the pieces of a pair do, p pieces and k multipliers; all but `feet` and `number` is scratch.

    feet     (p, 4) xi and eta where pieces begin, and where they end, see `ContactAlgorithm.feet`
    number   (N,) numbers of global nodes among those that rows touch, -1 for none
    angle    (m,) numbers of the angles of slave nodes, -1 for none
    place, seen  entries of nodes and of angles in the row that is being made
    first, last  (k,) pieces of each multiplier
    local    (p, 6) numbers of the slave's and the master's two nodes, and of the angles of the former; -1 in pieces
             that are too short for their ends to be told apart
    rate     (p, 2, 2) [1/mm] d(eta) of both ends by motions of the slave against the master
    lever    (p, 2, 2) [-] d(eta) by angles of the slave's nodes
    along    (p, 2) [mm] the master segment
    changes  (6, 2) of one multiplier of one piece, by its nodes and angles
    """

    feet: Floats2
    number: Ints1
    angle: Ints1
    place: Ints1
    seen: Ints1
    first: Ints1
    last: Ints1
    local: Ints2
    rate: Floats3
    lever: Floats3
    along: Floats2
    changes: Floats2


@section
def _local(node, number, rows):
    """Number of a global node among those that rows touch."""
    if number[node] < 0:
        number[node] = rows.used[0]
        rows.nodes[rows.used[0]] = node
        rows.used[0] += 1
    return number[node]


@section
def _angle(v, at, ends, rows):
    """Number of the angle of the averaged normal of slave node v."""
    if ends.angle[v] < 0:
        before, after = at.node_segments[v, 0], at.node_segments[v, 1]
        b = at.segments[before, 0] if before >= 0 else v
        c = at.segments[after, 1] if after >= 0 else v
        x, y = at.slave_at[c, 0] - at.slave_at[b, 0], at.slave_at[c, 1] - at.slave_at[b, 1]
        a, square = rows.used[1], x * x + y * y
        rows.ends[a, 0] = _local(at.slave[b], ends.number, rows)
        rows.ends[a, 1] = _local(at.slave[c], ends.number, rows)
        rows.turn[a, 0], rows.turn[a, 1] = -y / square, x / square
        ends.angle[v] = a
        rows.used[1] += 1
    return ends.angle[v]


@section
def _measure_ends(p, at, pieces, ends):
    """Rates of both ends of piece p, which are joined along the normals of its slave nodes.

    At an end of a slave segment eta moves; at a node of the master xi does, which a fixed place of the slave sees as
    eta that moves by the slope of the piece.
    """
    a, b, c, d = pieces.slave[p, 0], pieces.slave[p, 1], pieces.master[p, 0], pieces.master[p, 1]
    mx, my = at.master_at[d, 0] - at.master_at[c, 0], at.master_at[d, 1] - at.master_at[c, 1]
    ex, ey = at.slave_at[b, 0] - at.slave_at[a, 0], at.slave_at[b, 1] - at.slave_at[a, 1]
    ax, ay, bx, by = pieces.normal[a, 0], pieces.normal[a, 1], pieces.normal[b, 0], pieces.normal[b, 1]
    slope = (ends.feet[p, 3] - ends.feet[p, 1]) / (ends.feet[p, 2] - ends.feet[p, 0])
    ends.along[p, 0], ends.along[p, 1] = mx, my
    for e in range(2):
        xi, eta = ends.feet[p, 2 * e], ends.feet[p, 2 * e + 1]
        own = 1.0 - xi
        qx, qy = own * ax + xi * bx, own * ay + xi * by
        rx = at.slave_at[a, 0] + xi * ex - at.master_at[c, 0] - eta * mx
        ry = at.slave_at[a, 1] + xi * ey - at.master_at[c, 1] - eta * my
        if xi == e:
            over = 1.0 / (mx * qy - my * qx)
        else:
            over = slope / ((ex * qy - ey * qx) + (rx * (by - ay) - ry * (bx - ax)))
        ends.rate[p, e, 0], ends.rate[p, e, 1] = over * qy, -over * qx
        ends.lever[p, e, 0], ends.lever[p, e, 1] = over * own * (rx * ax + ry * ay), over * xi * (rx * bx + ry * by)


@section
def _collect(pair, count, ends, rows):
    """Number the nodes of all pieces, and measure their ends."""
    at, pieces, owner = pair.places, pair.pieces, pair.coupling.owner
    for k in range(owner.size):
        ends.first[k], ends.last[k] = count, -1
    for p in range(count):
        for j in range(2):
            k = owner[pieces.multiplier[p, j]]
            if k >= 0:
                ends.first[k], ends.last[k] = min(ends.first[k], p), p
            ends.local[p, j] = _local(at.slave[pieces.slave[p, j]], ends.number, rows)
            ends.local[p, 2 + j] = _local(at.master[pieces.master[p, j]], ends.number, rows)
        ends.local[p, 4] = -1
        if ends.feet[p, 2] - ends.feet[p, 0] > SHORT:
            for j in range(2):
                ends.local[p, 4 + j] = _angle(pieces.slave[p, j], at, ends, rows)
            _measure_ends(p, at, pieces, ends)


@section
def _changes(p, j, T, ends):
    """What multiplier j of piece p changes by along the master, by motions of four nodes and by two angles."""
    low, out = ends.feet[p, 0], ends.changes
    whole = T[p, 0, j] + T[p, 1, j]
    ahead = (T[p, 1, j] - low * whole) / (ends.feet[p, 2] - low)
    for v in range(6):
        out[v, 0], out[v, 1] = 0.0, 0.0
    for e in range(2):
        beta = ahead if e == 1 else whole - ahead
        x, y, xi, eta = (
            beta * ends.rate[p, e, 0],
            beta * ends.rate[p, e, 1],
            ends.feet[p, 2 * e],
            ends.feet[p, 2 * e + 1],
        )
        out[0, 0] += (1.0 - xi) * x
        out[0, 1] += (1.0 - xi) * y
        out[1, 0] += xi * x
        out[1, 1] += xi * y
        out[2, 0] -= (1.0 - eta) * x
        out[2, 1] -= (1.0 - eta) * y
        out[3, 0] -= eta * x
        out[3, 1] -= eta * y
        out[4, 0] += beta * ends.lever[p, e, 0]
        out[5, 0] += beta * ends.lever[p, e, 1]


@section
def _add_weights(p, j, pair, ends, at, begin, rows):
    """Add weights of multiplier j of piece p to the row that began at `begin`; returns the next free entry."""
    pieces, changing, single = pair.pieces, ends.local[p, 4] >= 0, pair.columns.single[0]
    mx, my, change = ends.along[p, 0], ends.along[p, 1], ends.changes
    for v in range(2 if single and not changing else 0, 4):
        n = ends.local[p, v]
        if v < 2:
            weight = 0.0 if single else pieces.D[p, v, j]
        else:
            weight = -pieces.M[p, v - 2, j]
        if ends.place[n] < begin:
            ends.place[n], rows.factors.node[at] = at, n
            rows.block[at, 0, 0], rows.block[at, 0, 1], rows.block[at, 1, 0], rows.block[at, 1, 1] = 0.0, 0.0, 0.0, 0.0
            at += 1
        z = ends.place[n]
        rows.block[z, 0, 0] += weight
        rows.block[z, 1, 1] += weight
        if changing:
            rows.block[z, 0, 0] -= mx * change[v, 0]
            rows.block[z, 0, 1] -= mx * change[v, 1]
            rows.block[z, 1, 0] -= my * change[v, 0]
            rows.block[z, 1, 1] -= my * change[v, 1]
    return at


@section
def _add_levers(p, ends, at, begin, rows):
    """The same for angles."""
    for v in range(4, 6):
        a = ends.local[p, v]
        if ends.seen[a] < begin:
            ends.seen[a], rows.angle[at] = at, a
            rows.lever[at, 0], rows.lever[at, 1] = 0.0, 0.0
            at += 1
        z = ends.seen[a]
        rows.lever[z, 0] -= ends.along[p, 0] * ends.changes[v, 0]
        rows.lever[z, 1] -= ends.along[p, 1] * ends.changes[v, 0]
    return at


@section
def _finish_row(row, k, first_slot, pair, ends, rows):
    """All of condition k that is no entry."""
    f, c, at = rows.factors, pair.coupling, pair.places
    nx, ny, p = pair.pieces.normal[k, 0], pair.pieces.normal[k, 1], c.previous[k]
    x, y = pair.gaps.separation[k, 0], pair.gaps.separation[k, 1]
    f.own[row] = _local(at.slave[k], ends.number, rows) if pair.columns.single[0] else -1
    f.normal[row, 0], f.normal[row, 1], f.gap[row] = nx, ny, pair.gaps.gaps[k, 0]
    f.size[row], f.slot[row] = c.full[k], first_slot + k
    f.above[row], f.below[row] = (c.upper[p], c.lower[k]) if p >= 0 else (0.0, 0.0)
    f.inverse[row] = 1.0 / c.pivot[k]
    rows.own_angle[row], rows.spin[row] = _angle(k, at, ends, rows), y * nx - x * ny


@section
def _begin(row, ends, rows):
    """Forget the numbers of the step before; entries of nodes and angles are as new."""
    if row == 0:
        for n in range(rows.used[0]):
            ends.number[rows.nodes[n]] = -1
        rows.used[0], rows.used[1] = 0, 0
    for v in range(ends.angle.size):
        ends.angle[v] = -1
    for n in range(ends.place.size):
        ends.place[n], ends.seen[n] = -1, -1


@table_kernel
def write_gradients(bound, bound_ends, count, first_slot, row, bound_rows):
    """Append all conditions of a pair with straight edges to the `row` ones of the model; returns their number, or -1.

    bound, bound_ends, bound_rows  addresses of a `PairTable`, an `EndsTable`, and a `FactoredGradientsTable`; -1 where
                                   the latter has no room
    count  pieces in use
    """
    pair, rows, ends = (
        unpack(bound, PairTable),
        unpack(bound_rows, FactoredGradientsTable),
        unpack(bound_ends, EndsTable),
    )
    c, f, multiplier = pair.coupling, rows.factors, pair.pieces.multiplier
    _begin(row, ends, rows)
    _collect(pair, count, ends, rows)
    at, angle_at = f.start[row], rows.angle_start[row]
    for i in range(c.kept[0]):
        k, begin, angle_begin = c.order[i], at, angle_at
        room = 4 * max(0, ends.last[k] + 1 - ends.first[k])
        if row >= f.gap.size or max(at, angle_at) + room > f.node.size:
            return -1
        for p in range(ends.first[k], ends.last[k] + 1):
            for j in range(2):
                if c.owner[multiplier[p, j]] == k:
                    if ends.local[p, 4] >= 0:
                        _changes(p, j, pair.pieces.T, ends)
                        angle_at = _add_levers(p, ends, angle_at, angle_begin, rows)
                    at = _add_weights(p, j, pair, ends, at, begin, rows)
        _finish_row(row, k, first_slot, pair, ends, rows)
        row += 1
        f.start[row], rows.angle_start[row] = at, angle_at
    return row


@kernel
def allow_factored_motion(count, bound_rows, current, predicted, velocity, last_dt):
    """From gaps of the first `count` rows at the start of the step to what has to be held at its end (`allow_motion`).

    `bound_rows` is the address of a `FactoredGradientsTable`.
    """
    rows = unpack(bound_rows, FactoredGradientsTable)
    size, gap = rows.used[0], rows.factors.gap
    step, came = np.empty((size, 2)), np.empty((size, 2))
    for n in range(size):
        node = rows.nodes[n]
        for c in range(2):
            step[n, c], came[n, c] = predicted[node, c] - current[node, c], last_dt * velocity[node, c]
    turned, carried, moved, closed = np.empty(rows.used[1]), np.empty((2, count)), np.empty(count), np.empty(count)
    conditions_moved(rows, count, step, turned, carried, moved)
    conditions_moved(rows, count, came, turned, carried, closed)
    for i in range(count):
        allowed = min(-gap[i], -closed[i], 0.0)
        rows.offset[i] = gap[i] + allowed
        gap[i] = moved[i] - allowed
