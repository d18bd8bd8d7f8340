"""Rows of consistent forces before their coupling is inverted: gaps differentiated by all that they depend on.

The weights of a piece change with the positions of its points on the master. Seen from a fixed point of the slave, one
moves along its segment linearly between the ends of the piece: by beta_e m d(eta_e) for a multiplier, m the segment and
beta_e the integral of psi times the hat of end e. Ends of adjacent pieces cancel, and so do, if the overlap is
closed, the lengths that a separation is integrated over (docs/theory/contact-energy.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.compiled.bound_arrays import Floats2, Floats3, Ints1, Ints2
from contactlab.api.compiled.gradient_products import conditions_moved
from contactlab.api.compiled.kernel import kernel, point, section, table_kernel
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.pair import PairTable

SHORT = 1e-7  # of a segment: changes along shorter pieces are below the round-off of their ends


class EndsTable(NamedTuple):
    """Overlap ends of a pair, p integration segments and k multipliers; all but `feet` and `number` is scratch.

    feet     (p, 4) xi and eta at the start of pieces, and at their end, see `ContactAlgorithm.feet`
    number   (N,) numbers of global nodes among the nodes of rows, -1 for none
    angle    (m,) numbers of the angles of slave nodes, -1 for none
    place, seen  entries of nodes and of angles in the present row
    first, last  (k,) pieces of each multiplier
    local    (p, 6) numbers of the slave's and the master's two nodes, and of the angles of the slave's; -1 in pieces
             that are too short to resolve their ends
    rate     (p, 2, 2) [1/mm] d(eta) of both ends by motions of the slave relative to the master
    lever    (p, 2, 2) [-] d(eta) by angles of the slave's nodes
    along    (p, 2) [mm] the master segment
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


@section
def _local(node, number, rows):
    """Return the number of a global node among the nodes of rows."""
    if number[node] < 0:
        number[node] = rows.used[0]
        rows.nodes[rows.used[0]] = node
        rows.used[0] += 1
    return number[node]


@section
def _angle(v, at, ends, rows):
    """Return the number of the angle of the averaged normal of slave node v."""
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
    """Compute rates of both ends of piece p, which are joined along the normals of its slave nodes.

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
    at, pieces, owner, number = pair.places, pair.pieces, pair.coupling.owner, ends.number
    for k in range(owner.size):
        ends.first[k], ends.last[k] = count, -1
    for p in range(count):
        for j in range(2):
            k = owner[pieces.multiplier[p, j]]
            if k >= 0:
                ends.first[k], ends.last[k] = min(ends.first[k], p), p
            ends.local[p, j] = _local(at.slave[pieces.slave[p, j]], number, rows)
            ends.local[p, 2 + j] = _local(at.master[pieces.master[p, j]], number, rows)
        ends.local[p, 4] = -1
        if ends.feet[p, 2] - ends.feet[p, 0] > SHORT:
            for j in range(2):
                ends.local[p, 4 + j] = _angle(pieces.slave[p, j], at, ends, rows)
            _measure_ends(p, at, pieces, ends)


@section
def _add_block(n, block, ends, at, begin, rows):
    """Add a block (xx, xy, yx, yy) of node n to the row that began at `begin`. Return the next free entry."""
    z = ends.place[n]
    if z >= begin:
        rows.block[z, 0, 0] += block[0]
        rows.block[z, 0, 1] += block[1]
        rows.block[z, 1, 0] += block[2]
        rows.block[z, 1, 1] += block[3]
        return at
    ends.place[n], rows.factors.node[at] = at, n
    rows.block[at, 0, 0], rows.block[at, 0, 1], rows.block[at, 1, 0], rows.block[at, 1, 1] = block
    return at + 1


@section
def _add_lever(a, x, y, ends, at, begin, rows):
    """Add the entry of an angle. Return the next free entry."""
    z = ends.seen[a]
    if z >= begin:
        rows.lever[z, 0] += x
        rows.lever[z, 1] += y
        return at
    ends.seen[a], rows.angle[at] = at, a
    rows.lever[at, 0], rows.lever[at, 1] = x, y
    return at + 1


class PieceSums(NamedTuple):
    """Sums over the multipliers of a piece merged into one: integrals of their psi times shape functions and hats.

    d0, d1  D of both slave nodes, m0, m1 M of both master nodes
    t       the integral of psi, ahead: of psi times the second hat
    """

    d0: float
    d1: float
    m0: float
    m1: float
    t: float
    ahead: float


class EndsMove(NamedTuple):
    """Sum of beta_e d(eta_e) over both ends of a piece, by motions (x, y) of its nodes and angles of its normals.

    a, b        per motion of the slave's two nodes, c, d of the master's
    at_a, at_b  per angle of the slave's two normals
    """

    a: tuple[float, float]
    b: tuple[float, float]
    c: tuple[float, float]
    d: tuple[float, float]
    at_a: float
    at_b: float


@point
def _sum(one, other):
    return one[0] + other[0], one[1] + other[1], one[2] + other[2], one[3] + other[3]


@point
def _less(block, m, move):
    """Return a block (xx, xy, yx, yy) less the product of the columns m and `move`."""
    return block[0] - m[0] * move[0], block[1] - m[0] * move[1], block[2] - m[1] * move[0], block[3] - m[1] * move[1]


@section
def _own_sums(p, k, pieces, owner):
    """Return `PieceSums` of the multipliers of piece p merged into k."""
    first, second = 0.0, 0.0
    if owner[pieces.multiplier[p, 0]] == k:
        first = 1.0
    if owner[pieces.multiplier[p, 1]] == k:
        second = 1.0
    D, M, T = pieces.D, pieces.M, pieces.T
    ahead = first * T[p, 1, 0] + second * T[p, 1, 1]
    return PieceSums(
        first * D[p, 0, 0] + second * D[p, 0, 1], first * D[p, 1, 0] + second * D[p, 1, 1],
        first * M[p, 0, 0] + second * M[p, 0, 1], first * M[p, 1, 0] + second * M[p, 1, 1],
        first * T[p, 0, 0] + second * T[p, 0, 1] + ahead, ahead,
    )  # fmt: skip


@section
def _ends_move(p, sums, ends):
    """Return `EndsMove` of piece p: `under` and `over` are beta of its first and second end.

    beta_e is the integral of psi times the hat of end e of the piece, which is linear in xi, as the slave's hats are.
    """
    low, eta_low, high, eta_high = ends.feet[p, 0], ends.feet[p, 1], ends.feet[p, 2], ends.feet[p, 3]
    over = (sums.ahead - low * sums.t) / (high - low)
    under = sums.t - over
    x0, y0 = under * ends.rate[p, 0, 0], under * ends.rate[p, 0, 1]
    x1, y1 = over * ends.rate[p, 1, 0], over * ends.rate[p, 1, 1]
    x, y, bx, by = x0 + x1, y0 + y1, low * x0 + high * x1, low * y0 + high * y1
    dx, dy = eta_low * x0 + eta_high * x1, eta_low * y0 + eta_high * y1
    first = under * ends.lever[p, 0, 0] + over * ends.lever[p, 1, 0]
    second = under * ends.lever[p, 0, 1] + over * ends.lever[p, 1, 1]
    return EndsMove((x - bx, y - by), (bx, by), (dx - x, dy - y), (-dx, -dy), first, second)


@section
def _add_slave(nodes, blocks, ends, at, begin, rows):
    """Add blocks of both nodes of a slave segment, nothing for a segment of -1. Return the next free entry."""
    if nodes[0] >= 0:
        at = _add_block(nodes[0], blocks[0], ends, at, begin, rows)
        at = _add_block(nodes[1], blocks[1], ends, at, begin, rows)
    return at


@section
def _add_angles(angles, levers, ends, at, begin, rows):
    """Add entries of their angles. Return the next free entry."""
    if angles[0] >= 0:
        at = _add_lever(angles[0], levers[0], levers[1], ends, at, begin, rows)
        at = _add_lever(angles[1], levers[2], levers[3], ends, at, begin, rows)
    return at


@section
def _write_entries(k, pair, ends, at, angle_at, rows):
    """Write the entries of row k of B, of nodes and of angles, from here on. Return the next free entries.

    A piece with the master segment m adds D dx - M dy - m (beta_0 d(eta_0) + beta_1 d(eta_1)), see `EndsMove`
    (docs/theory/contact-energy.md, implementation). A slave segment sums over its pieces; a node of the master that
    ends one piece begins the next.
    """
    begin, angle_begin, local, zero = at, angle_at, ends.local, (0.0, 0.0, 0.0, 0.0)
    single = pair.coupling.single[0]
    slave, slave_blocks, angles, levers, waiting, kept = (-1, -1), (zero, zero), (-1, -1), zero, -1, zero
    for p in range(ends.first[k], ends.last[k] + 1):
        sums = _own_sums(p, k, pair.pieces, pair.coupling.owner)
        d0, d1, m0, m1 = sums.d0, sums.d1, sums.m0, sums.m1
        if sums.t == 0.0 and m0 == 0.0 and m1 == 0.0:
            continue
        c, d, changing = local[p, 2], local[p, 3], local[p, 4] >= 0
        master_blocks = (-m0, 0.0, 0.0, -m0), (-m1, 0.0, 0.0, -m1)
        if (changing or not single) and slave[0] != local[p, 0]:
            at = _add_slave(slave, slave_blocks, ends, at, begin, rows)
            slave, slave_blocks = (local[p, 0], local[p, 1]), (zero, zero)
        if not single:
            slave_blocks = _sum(slave_blocks[0], (d0, 0.0, 0.0, d0)), _sum(slave_blocks[1], (d1, 0.0, 0.0, d1))
        if changing:
            if angles[0] != local[p, 4]:
                angle_at = _add_angles(angles, levers, ends, angle_at, angle_begin, rows)
                angles, levers = (local[p, 4], local[p, 5]), zero
            m, move = (ends.along[p, 0], ends.along[p, 1]), _ends_move(p, sums, ends)
            slave_blocks = _less(slave_blocks[0], m, move.a), _less(slave_blocks[1], m, move.b)
            master_blocks = _less(master_blocks[0], m, move.c), _less(master_blocks[1], m, move.d)
            levers = _less(levers, (move.at_a, move.at_b), m)
        if waiting == c:
            at = _add_block(c, _sum(master_blocks[0], kept), ends, at, begin, rows)
            waiting, kept = d, master_blocks[1]
        else:
            if waiting == d:
                master_blocks = master_blocks[0], _sum(master_blocks[1], kept)
            elif waiting >= 0:
                at = _add_block(waiting, kept, ends, at, begin, rows)
            at = _add_block(d, master_blocks[1], ends, at, begin, rows)
            waiting, kept = c, master_blocks[0]
    at = _add_slave(slave, slave_blocks, ends, at, begin, rows)
    if waiting >= 0:
        at = _add_block(waiting, kept, ends, at, begin, rows)
    return at, _add_angles(angles, levers, ends, angle_at, angle_begin, rows)


@section
def _finish_row(row, k, first_slot, pair, ends, rows):
    """Write all of constraint k except its entries."""
    f, c, at = rows.factors, pair.coupling, pair.places
    nx, ny, p = pair.pieces.normal[k, 0], pair.pieces.normal[k, 1], c.previous[k]
    x, y = pair.separation[k, 0], pair.separation[k, 1]
    f.own[row] = _local(at.slave[k], ends.number, rows) if pair.coupling.single[0] else -1
    f.normal[row, 0], f.normal[row, 1], f.gap[row] = nx, ny, pair.gaps[k, 0]
    f.size[row], f.slot[row] = c.full[k], first_slot + k
    f.above[row], f.below[row] = (c.upper[p], c.lower[k]) if p >= 0 else (0.0, 0.0)
    f.inverse[row] = 1.0 / c.pivot[k]
    rows.own_angle[row], rows.spin[row] = _angle(k, at, ends, rows), y * nx - x * ny


@section
def _begin(row, ends, rows):
    """Clear the numbers of the last step; entries of nodes and angles are reset."""
    if row == 0:
        for n in range(rows.used[0]):
            ends.number[rows.nodes[n]] = -1
        rows.used[0], rows.used[1] = 0, 0
    for v in range(ends.angle.size):
        ends.angle[v] = -1
    for n in range(ends.place.size):
        ends.place[n], ends.seen[n] = -1, -1


@table_kernel
def write_gradients(bound, bound_ends, count, first_slot, row, rows):
    """Append all constraints of a pair with straight edges to the `row` rows of the model. Return their number, or -1.

    bound, bound_ends  addresses of a `PairTable` and an `EndsTable`
    count  pieces in use
    rows   `FactoredGradients` of the model; -1 is returned if they have no room
    """
    pair, ends = unpack(bound, PairTable), unpack(bound_ends, EndsTable)
    c, f = pair.coupling, rows.factors
    _begin(row, ends, rows)
    _collect(pair, count, ends, rows)
    at, angle_at = f.start[row], rows.angle_start[row]
    for i in range(c.kept[0]):
        k = c.order[i]
        room = 4 * max(0, ends.last[k] + 1 - ends.first[k])
        if row >= f.gap.size or max(at, angle_at) + room > f.node.size:
            return -1
        at, angle_at = _write_entries(k, pair, ends, at, angle_at, rows)
        _finish_row(row, k, first_slot, pair, ends, rows)
        row += 1
        f.start[row], rows.angle_start[row] = at, angle_at
    return row


@kernel
def allow_factored_motion(count, rows, current, predicted, velocity, last_dt):
    """Replace `gap`, first g at the start of the step, by the constraint d >= d0 of its end, in the first `count` rows.

    gap = d - d0, d0 = min(-g, -u, 0), offset = g + d0: d = G (predicted - current) is the change of the gap in the
    step without contact forces, u = G (last_dt velocity) in the step before (`allow_motion`).
    """
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
