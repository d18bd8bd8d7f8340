"""All pieces of a mortar contact: slave segment by slave segment, overlap by overlap."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import point, section, table_kernel
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.integrals import integrate, integrate_straight
from contactlab_mortar.normals import inward_normals
from contactlab_mortar.overlap import facing, is_empty, overlap, overlap_between
from contactlab_mortar.projection import master_segment, slave_parameter, slave_segment
from contactlab_mortar.tables import MortarTable
from contactlab_mortar.vertices import turn_at_vertices


@point
def _tilt(slave, length):
    """Largest slope of the field of normals against the segment's own normal."""
    tx, ty, nx, ny = slave.ex / length, slave.ey / length, slave.nx, slave.ny
    ox, oy = nx + slave.mx, ny + slave.my
    a = abs(nx * tx + ny * ty) / max(abs(nx * ty - ny * tx), 1e-3)
    b = abs(ox * tx + oy * ty) / max(abs(ox * ty - oy * tx), 1e-3)
    return max(a, b)


@point
def _beside(slave, length, px, py):
    """How far (px, py) lies along the slave segment from its start, and how far away from its line."""
    tx, ty, x, y = slave.ex / length, slave.ey / length, px - slave.ax, py - slave.ay
    return x * tx + y * ty, abs(x * ty - y * tx)


@point
def _passes(found, length, starts, ends):
    """Whether the end of a chain slips past the end of the other: deeper behind it by twice what both overlap.

    That is the far flank of a corner whose near flank carries the contact.
    """
    at_end = (starts and found.low == 0.0) or (ends and found.high == 1.0)
    return at_end and -min(found.gap_low, found.gap_high) > 2.0 * (found.high - found.low) * length


@point
def carriers(s, edges, segment_edge):
    """Ends of the quadratic edge of slave segment s: first the one that this half touches, then the other."""
    edge, half = segment_edge[s, 0], segment_edge[s, 1]
    return edges[edge, half], edges[edge, 1 - half]


@point
def multipliers_of(s, slave, vertices):
    """The two multipliers of slave segment s: at its ends, or with `vertices` at those of its quadratic edge."""
    if vertices and slave.edges.shape[1] == 3:
        return carriers(s, slave.edges, slave.segment_edge)
    return slave.segments[s, 0], slave.segments[s, 1]


@point
def halves_of(s, m, sides, vertices):
    """What of their edges slave segment s and master segment m are, and what hats span; see `integrals`."""
    half = sides.slave.segment_edge[s, 1]
    spanned = half + 1 if vertices and sides.slave.edges.shape[1] == 3 else 0
    return half, sides.master.segment_edge[m, 1], spanned


@section
def _put_edge(edges, edge, p, nodes, values):
    """Nodes of an edge into piece p, and zero for the integrals of its traces."""
    for i in range(edges.shape[1]):
        nodes[p, i] = edges[edge, i]
        values[p, i, 0], values[p, i, 1] = 0.0, 0.0


@section
def begin_piece(s, m, sides, vertices, p, out):
    """Nodes and multipliers of segments s and m into entry p of out, with zero for the integrals.

    out = slave, multiplier, master, D, M, T
    """
    slave, multiplier, master, D, M, T = out
    multiplier[p, 0], multiplier[p, 1] = multipliers_of(s, sides.slave, vertices)
    _put_edge(sides.slave.edges, sides.slave.segment_edge[s, 0], p, slave, D)
    _put_edge(sides.master.edges, sides.master.segment_edge[m, 0], p, master, M)
    for k in range(2):
        T[p, k, 0], T[p, k, 1] = 0.0, 0.0


@section
def _put_piece(table, s, m, found, length, space, p):
    """Write piece p, integrated as on a slave segment of `length` [mm]; space = (linear, vertices)."""
    sides, pieces, feet, (linear, vertices) = table.sides, table.pieces, table.feet, space
    if feet.shape[0] > 0:
        feet[p, 0], feet[p, 1], feet[p, 2], feet[p, 3] = found.low, found.eta_low, found.high, found.eta_high
    out = pieces.D, pieces.M, pieces.T
    if pieces.D.shape[1] == 2 and pieces.M.shape[1] == 2:
        for i in range(2):
            pieces.multiplier[p, i] = pieces.slave[p, i] = sides.slave.segments[s, i]
            pieces.master[p, i] = sides.master.segments[m, i]
        integrate_straight(found, length, linear, p, out)
    else:
        begin_piece(s, m, sides, vertices, p, (pieces.slave, pieces.multiplier, pieces.master, *out))
        integrate(found, length, halves_of(s, m, sides, vertices), linear, p, out)


@section
def _pieces_of(table, s, reach, depth, space, begin):
    """Pieces of slave segment s from `begin` on; returns the next free one."""
    sides, close, count = table.sides, False, begin
    slave = slave_segment(s, sides.slave_at, sides.slave.segments, table.pieces.normal)
    starts = sides.slave.node_segments[sides.slave.segments[s, 0], 0] < 0
    ends = sides.slave.node_segments[sides.slave.segments[s, 1], 1] < 0
    length = np.sqrt(slave.ex * slave.ex + slave.ey * slave.ey)
    tilt, slack = _tilt(slave, length), 1e-9 * length
    # neighbours on the master share a node: where it lies and from where it is seen is worked out once
    last, seen, parameter, d_along, d_away = -1, -1, 0.0, 0.0, 0.0
    for z in range(sides.start[s], sides.start[s + 1]):
        m = sides.candidates[z]
        first_node, second_node = sides.master.segments[m, 0], sides.master.segments[m, 1]
        master = master_segment(m, sides.master_at, sides.master.segments)
        c_along, c_away = d_along, d_away
        if last != first_node:
            c_along, c_away = _beside(slave, length, master.cx, master.cy)
        d_along, d_away = _beside(slave, length, master.dx, master.dy)
        last = second_node
        # beside the slave segment, beyond where any of its normals leads
        beyond = tilt * max(c_away, d_away) + slack
        if max(c_along, d_along) < -beyond or min(c_along, d_along) > length + beyond:
            continue
        weight = facing(slave, master)
        if not weight > 0.0:
            continue
        first = parameter if seen == first_node else slave_parameter(slave, master.cx, master.cy)
        second = slave_parameter(slave, master.dx, master.dy)
        seen, parameter = second_node, second
        found = overlap_between(first, second, slave, master)
        least = min(found.gap_low, found.gap_high)
        if is_empty(found) or least < -depth or _passes(found, length, starts, ends):
            continue
        close = close or least <= reach
        _put_piece(table, s, m, found, weight * length, space, count)
        count += 1
    return count if close else begin


@table_kernel
def mortar_pieces(bound, reach, depth, linear, vertices):
    """Fill the pieces; returns their number.

    `bound` is the address of a `MortarTable`.
    A slave segment farther than `reach` [mm] or deeper than `depth` segments at all its overlaps is left out.
    `vertices`: multipliers of quadratic slave edges belong to their ends alone.
    """
    table = unpack(bound, MortarTable)
    sides, pieces = table.sides, table.pieces
    slave = sides.slave
    depth *= inward_normals(sides.slave_at, slave.segments, slave.node_segments, pieces.normal)
    count = 0
    for s in range(slave.segments.shape[0]):
        if sides.start[s] < sides.start[s + 1]:
            count = _pieces_of(table, s, reach, depth, (linear, vertices), count)
    arrays, chain = (pieces.multiplier, pieces.master, pieces.T), (slave.segments, slave.node_segments)
    turned = turn_at_vertices(count, arrays, chain, sides.slave_at, sides.master_at, pieces.normal)
    table.made[0], table.made[1] = count, turned
    return count


@section
def segments_of(sides, pieces, count, inward, vertices, out):
    """Slave and master segment of each piece into out (count, 2); ValueError where pieces are not those of the sides.

    Pieces tell edges: of a quadratic one the half that has an overlap is taken, in the order of `mortar_pieces`.
    """
    p = 0
    for s in range(sides.slave.segments.shape[0]):
        first, second = multipliers_of(s, sides.slave, vertices)
        slave = slave_segment(s, sides.slave_at, sides.slave.segments, inward)
        for z in range(sides.start[s], sides.start[s + 1]):
            if p >= count or pieces.multiplier[p, 0] != first or pieces.multiplier[p, 1] != second:
                break
            m = sides.candidates[z]
            edge = sides.master.segment_edge[m, 0]
            if sides.master.edges[edge, 0] != pieces.master[p, 0] or sides.master.edges[edge, 1] != pieces.master[p, 1]:
                continue
            if not is_empty(overlap(slave, master_segment(m, sides.master_at, sides.master.segments))):
                out[p, 0], out[p, 1] = s, m
                p += 1
    if p < count:
        raise ValueError("mortar: pieces of other positions or of another near list than the ones given with them")
