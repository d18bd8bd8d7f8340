"""All pieces of a mortar contact: slave segment by slave segment, overlap by overlap."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import point, section, table_kernel
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.integrals import integrate, integrate_straight
from contactlab_mortar.normals import inward_normals
from contactlab_mortar.overlap import facing, is_empty, overlap, overlap_between
from contactlab_mortar.projection import (
    across,
    master_segment,
    opening,
    parameter_beside,
    segment_between,
    slave_segment,
)
from contactlab_mortar.tables import MortarTable
from contactlab_mortar.vertices import turn_at_vertices

NONE = np.uint32(0xFFFFFFFF)  # no node. Numbers without sign spare the test for places counted from the end


@point
def _tilt(slave, length):
    """Largest slope of the field of normals against the segment's own normal."""
    ex, ey, nx, ny, least = slave.ex, slave.ey, slave.nx, slave.ny, 1e-3 * length
    ox, oy = nx + slave.mx, ny + slave.my
    a, upright = abs(nx * ex + ny * ey), max(abs(nx * ey - ny * ex), least)
    b, beyond = abs(ox * ex + oy * ey), max(abs(ox * ey - oy * ex), least)
    return max(a * beyond, b * upright) / (upright * beyond)


@point
def _beside(slave, px, py):
    """How far (px, py) lies along the slave segment from its start, and how far from its line, times its length."""
    x, y = px - slave.ax, py - slave.ay
    return x * slave.ex + y * slave.ey, abs(x * slave.ey - y * slave.ex)


@point
def _side(along, square, beyond):
    """-1 for a point before where any normal of the slave segment leads, 1 for one beyond, else 0."""
    return -1 if along < -beyond else (1 if along > square + beyond else 0)


@point
def _farthest(found, slave, master):
    """Square of the larger distance [mm^2] of both segments at the ends of an overlap: no gap or depth exceeds it."""
    x, y = across(found.low, found.eta_low, slave, master)
    u, v = across(found.high, found.eta_high, slave, master)
    return max(x * x + y * y, u * u + v * v)


@point
def _least_gap(found, slave, master):
    """The smaller gap [mm] of both ends of an overlap."""
    low, high = opening(found.low, found.eta_low, slave, master), opening(found.high, found.eta_high, slave, master)
    return min(low, high)


@point
def _passes(found, slave, master, length, chain):
    """Whether the end of a chain slips past the end of the other: deeper behind it by twice what both overlap.

    That is the far flank of a corner whose near flank carries the contact. chain = whether it starts, ends here
    """
    if (chain[0] and found.low == 0.0) or (chain[1] and found.high == 1.0):
        return -_least_gap(found, slave, master) > 2.0 * (found.high - found.low) * length
    return False


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
    tilt, square = _tilt(slave, length), length * length
    # neighbours on the master share a node: where it lies and from where it is seen is worked out once
    segments, at, near = sides.master.segments, sides.master_at, min(reach, depth) ** 2
    last, seen, parameter, d_along, d_away = NONE, NONE, 0.0, 0.0, 0.0
    for z in range(sides.start[s], sides.start[s + 1]):
        m = np.uint32(sides.candidates[z])
        i, j = np.uint32(segments[m, 0]), np.uint32(segments[m, 1])
        c_along, c_away = d_along, d_away
        if i != last:
            c_along, c_away = _beside(slave, at[i, 0], at[i, 1])
        d_along, d_away = _beside(slave, at[j, 0], at[j, 1])
        last = j
        # beside the slave segment, both ends beyond where normals lead to the farther one. Where normals lean by more
        # than 90 degrees it decides, too: a bound for each end by itself would pass over flanks that a corner presses
        beyond = tilt * max(c_away, d_away) + 1e-9 * square
        c_side, d_side = _side(c_along, square, beyond), _side(d_along, square, beyond)
        if c_side * d_side > 0:
            continue
        master = segment_between(i, j, at)
        weight = facing(slave, master)
        if not weight > 0.0:
            continue
        first = parameter if i == seen else parameter_beside(slave, c_side, master.cx, master.cy)
        second = parameter_beside(slave, d_side, master.dx, master.dy)
        seen, parameter = j, second
        found = overlap_between(first, second, slave, master)
        if is_empty(found) or _passes(found, slave, master, length, (starts, ends)):
            continue
        if _farthest(found, slave, master) <= near:
            close = True  # the usual case, without the roots and quotients of gaps
        else:
            gap = _least_gap(found, slave, master)
            if gap < -depth:
                continue
            close = close or gap <= reach
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
    depth *= inward_normals(sides.slave_at, slave.segments, pieces.normal)
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
