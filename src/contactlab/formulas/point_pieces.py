"""Pieces of single points of the slave in contact with a segment, a quadratic edge or a vertex of the master.

Slots: POINTS, the Gauss points of each slave segment, 0 for its nodes, ALONE, True if each has a multiplier of
its own, ABSCISSAE and WEIGHTS, their rule on 0 to 1;
FOOT(x, master, p), see `contactlab.api.segments`.

All sections work on a `Points` table t; q is the number of the point, x its `SlavePoint`, count the piece to write.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.dual import derivatives, seed, value
from contactlab.api.compiled.formulas import slots
from contactlab.api.compiled.kernel import point, section
from contactlab.api.segments import MasterSegment
from contactlab.api.tensors import Vector
from contactlab.formulas.segment_kernels import trace
from contactlab.formulas.segment_normals import node

FOOT, POINTS, ALONE, ABSCISSAE, WEIGHTS = slots("FOOT", "POINTS", "ALONE", "ABSCISSAE", "WEIGHTS")
SHARP = 0.17  # sine of the kink (10 degrees) from which a concave corner holds with both segments
NARROW = 0.01  # sine of the turn at a vertex below which it has one normal
AT_END = 1e-6  # shares of a segment end within which a node sits on the vertex
EDGE = 1e-9  # projection beyond a segment's end, in segment lengths
LEAVE = 0.02  # beyond the ends of a chain, of the shorter segment: bodies of one width spread differently


# --- geometry, of numbers and of dual numbers -------------------------------------------------------------------------


@point
def parabola(a, b, middle, s):
    """Return position and derivative by s of the edge through a (s = -1), middle (0) and b (1)."""
    half, bend = 0.5 * (b - a), a + b - 2.0 * middle
    return middle + s * (half + (0.5 * s) * bend), half + s * bend


@point
def tangent_at(a, b, middle, s):
    """Return the tangent there, as a master segment on which eta is the change of s."""
    start, edge = parabola(a, b, middle, s)
    return MasterSegment(start, start + edge)


@point
def in_wedge(x, v, before, after, length):
    """Return whether the line from a vertex at v to a point at x is a normal, between the normals of its segments.

    Within 1e-6 of the segments' `length` it is not: on the surface itself the line is round-off and points anywhere.
    Nor is it if segments hardly turn: it would cross the wedge while the point moves by less than its distance.
    """
    between = x - v
    if before.cross(after) < NARROW:
        return False
    if not (between @ (before + after) >= 0.0 and between @ between > (AT_END * length) ** 2):
        return False
    return before.cross(between) >= 0.0 and between.cross(after) >= 0.0


@section
def foot_on_parabola(x, a, b, middle, s, p):
    """Return s of the formula's projection on a quadratic edge, by Newton iterations on its tangents from s."""
    for _ in range(8):
        found = FOOT(x, tangent_at(a, b, middle, seed(s, 0, 4)), p)
        slope = derivatives(found, 4)[0]
        change = -value(found) / slope if slope < 0.0 else 0.0
        s = min(1.0, max(-1.0, s + change))
        if abs(change) < 1e-14:
            break
    return s


# --- one piece --------------------------------------------------------------------------------------------------------


@section
def put_slave(t, count, q, slot):
    """Write the slave's side of a piece: its nodes and multipliers, D, T, and `psi`."""
    view, out = t.sides, t.out
    if POINTS == 0:
        out.slave[count, 0], out.slave[count, 1] = q, q
        out.multiplier[count, 0] = slot * t.outward.shape[0] + q
        t.psi[0] = t.tributary[q]
        out.D[count, 0, 0], out.D[count, 1, 0], out.T[count, 0, 0] = t.psi[0], 0.0, t.psi[0]
        out.ends[count, 0] = 0.0
        return
    s = q // max(POINTS, 1)
    xi = ABSCISSAE[q - s * POINTS]
    weight, nodes = WEIGHTS[q - s * POINTS] * t.slave_length[s], view.slave.edges.shape[1]
    edge, half = view.slave.segment_edge[s, 0], view.slave.segment_edge[s, 1]
    out.ends[count, 0] = xi
    if ALONE:
        i, g = view.slave.segments[s, 0], q - s * POINTS
        out.multiplier[count, 0] = g * t.outward.shape[0] + i
        t.psi[0], out.T[count, 0, 0] = weight, weight
        for k in range(nodes):
            out.slave[count, k] = view.slave.edges[edge, k]
            out.D[count, k, 0] = trace(nodes, half, xi, k) * weight
        return
    t.psi[0], t.psi[1] = weight * (1.0 - xi), weight * xi
    for k in range(2):
        out.multiplier[count, k] = view.slave.segments[s, k]
        for i in range(nodes):
            out.slave[count, i] = view.slave.edges[edge, i]
            out.D[count, i, k] = trace(nodes, half, xi, i) * t.psi[k]
        out.T[count, 0, k], out.T[count, 1, k] = (1.0 - xi) * t.psi[k], xi * t.psi[k]


@section
def put_normal(t, count, x, y):
    """Write the normal of a multiplier that belongs to one point; Gauss points use the slave's normal."""
    k = t.out.multiplier[count, 0]
    if POINTS == 0:
        t.out.normal[k, 0], t.out.normal[k, 1] = x, y
    elif ALONE:
        s = t.out.segment[count, 0] // max(POINTS, 1)
        t.out.normal[k, 0], t.out.normal[k, 1] = -t.slave_normal[s, 0], -t.slave_normal[s, 1]


@section
def put_piece(t, count, q, slot, held):
    """Write a piece in row `slot` of its point: master segment m with shares 1 - share and share of its ends."""
    view, out = t.sides, t.out
    m, share, holder, x, y = held
    put_slave(t, count, q, slot)
    for i in range(2):
        out.master[count, i] = view.master.segments[m, i]
    if out.M.shape[1] == 3:
        out.master[count, 2] = view.master.segments[m, 0]
    for k in range(out.M.shape[2]):
        out.M[count, 0, k], out.M[count, 1, k] = (1.0 - share) * t.psi[k], share * t.psi[k]
        if out.M.shape[1] == 3:
            out.M[count, 2, k] = 0.0
    out.segment[count, 0], out.segment[count, 1] = q, holder
    out.ends[count, 1], out.ends[count, 2] = share, 0.0
    put_normal(t, count, x, y)


@section
def _end_normal(t, edge, s):
    """Return the normal of a quadratic edge of the master at its start (s = -1) or its end."""
    at, nodes = t.sides.at.master, t.sides.master.edges
    return parabola(node(at, nodes[edge, 0]), node(at, nodes[edge, 1]), node(at, nodes[edge, 2]), s)[1].turned().unit()


@section
def kink(t, first, second):
    """Return the sine of the master's turn between two segments, with quadratic edges at the node between them."""
    surface = t.sides.master
    if surface.edges.shape[1] == 2:
        return node(t.master_normal, first).cross(node(t.master_normal, second))
    one, other = surface.segment_edge[first, 0], surface.segment_edge[second, 0]
    return 0.0 if one == other else _end_normal(t, one, 1.0).cross(_end_normal(t, other, -1.0))


@section
def _beside(t, start, end, s, own):
    """Return the normal of the next quadratic edge in a flat valley, at the start (s = -1) or the end; else `own`.

    A node that presses in a valley oscillates between the normals of its flanks, however small the kink; a sharp
    valley holds it with both.
    """
    surface = t.sides.master
    other = surface.node_segments[start, 0] if s < 0.0 else surface.node_segments[end, 1]
    if other < 0:
        return own
    found = _end_normal(t, surface.segment_edge[other, 0], 1.0 if s < 0.0 else -1.0)
    return found if -SHARP < s * own.cross(found) < 0.0 else own


@section
def put_on_parabola(t, count, x, q, slot, m, s, p):
    """Write the piece of a point in contact with the quadratic edge of master segment m near s."""
    view, out = t.sides, t.out
    put_slave(t, count, q, slot)
    edge = view.master.segment_edge[m, 0]
    for i in range(3):
        out.master[count, i] = view.master.edges[edge, i]
    at, nodes = view.at.master, out.master
    a, b, middle = node(at, nodes[count, 0]), node(at, nodes[count, 1]), node(at, nodes[count, 2])
    s = foot_on_parabola(x, a, b, middle, s, p)
    for k in range(out.M.shape[2]):
        out.M[count, 0, k] = 0.5 * s * (s - 1.0) * t.psi[k]
        out.M[count, 1, k] = 0.5 * s * (s + 1.0) * t.psi[k]
        out.M[count, 2, k] = (1.0 - s * s) * t.psi[k]
    out.segment[count, 0], out.segment[count, 1] = q, m
    out.ends[count, 1], out.ends[count, 2] = s, 1.0
    normal = parabola(a, b, middle, s)[1].turned().unit()
    if abs(s) > 1.0 - AT_END:
        normal = (normal + _beside(t, nodes[count, 0], nodes[count, 1], s, normal)).unit()
    put_normal(t, count, normal.x, normal.y)


# --- contact of a point -----------------------------------------------------------------------------------------------


@section
def foot(t, x, m, p):
    """Return gap [mm] and eta of a point on the line of master segment m."""
    at, i, j = t.sides.at.master, t.sides.master.segments[m, 0], t.sides.master.segments[m, 1]
    master = MasterSegment(Vector(at[i, 0], at[i, 1]), Vector(at[j, 0], at[j, 1]))
    gap = (x.at.x - at[i, 0]) * t.master_normal[m, 0] + (x.at.y - at[i, 1]) * t.master_normal[m, 1]
    return gap, FOOT(x, master, p)


@section
def faces(t, x, q, m, least):
    """Return whether point q faces master segment m by more than the cosine `least`.

    A node at a corner of the slave counts once for each flank: the flank whose normal leads to a segment faces it.
    """
    n = node(t.master_normal, m)
    facing = -(x.normal @ n)
    return facing > least and (POINTS > 0 or not -(node(t.outward, t.rival[q]) @ n) > facing)


@section
def _end_reached(t, m, share):
    """Return the vertex that a point sits on, else -1: there neither segment's normal is better."""
    if share > AT_END and share < 1.0 - AT_END:
        return np.int64(-1)
    surface = t.sides.master
    v = surface.segments[m, 0] if share <= AT_END else surface.segments[m, 1]
    return np.int64(v) if surface.node_segments[v, 0] >= 0 and surface.node_segments[v, 1] >= 0 else np.int64(-1)


@section
def _second_side(t, x, q, m, reach, p):
    """Return the second contact segment, and eta there, of a node in a sharp concave corner that projects onto both."""
    surface = t.sides.master
    for side in range(2):
        other = surface.node_segments[surface.segments[m, side], side]
        if other < 0 or not faces(t, x, q, other, 0.0):
            continue
        first, second = (m, other) if side == 1 else (other, m)
        if kink(t, first, second) > -SHARP:
            continue
        gap, along = foot(t, x, other, p)
        if -LEAVE <= along <= 1.0 + LEAVE and abs(gap) <= reach:
            return np.int64(other), min(1.0, max(0.0, along))
    return np.int64(-1), 0.0


@section
def _of_segment(t, m, eta):
    """Return the contact data of a segment at eta: itself, the share of its end, the contact, and the normal."""
    return np.int64(m), eta, np.int64(m), t.master_normal[m, 0], t.master_normal[m, 1]


@section
def hold(t, count, x, q, nearest, v, reach, depth, p):
    """Write the contact of a point. Return the next piece.

    It is a segment and eta on it, `nearest`, or if the first is negative vertex v near the point. A quadratic edge
    holds at its closest point, also near the kink of its halves, where the true edge is smooth. A convex vertex holds
    along the line to the point, a concave vertex nodes with both segments, a slave corner with the segment it faces.
    """
    surface, (m, eta) = t.sides.master, nearest
    if surface.edges.shape[1] == 3:
        edge = m if m >= 0 else np.int64(surface.node_segments[v, 1])
        if m >= 0 or surface.segment_edge[edge, 1] == 1:
            s = eta + surface.segment_edge[m, 1] - 1.0 if m >= 0 else 0.0
            put_on_parabola(t, count, x, q, 0, edge, s, p)
            other, along = _second_side(t, x, q, edge, reach, p) if POINTS == 0 and m >= 0 else (np.int64(-1), 0.0)
            if other < 0:
                return count + 1
            put_on_parabola(t, count + 1, x, q, 1, other, along + surface.segment_edge[other, 1] - 1.0, p)
            return count + 2
    elif m >= 0:
        v = _end_reached(t, m, eta)
    number, first = 1, _of_segment(t, max(m, 0), eta)
    second = first
    if v >= 0:
        before, after = surface.node_segments[v, 0], surface.node_segments[v, 1]
        one, other = node(t.master_normal, before), node(t.master_normal, after)
        valley = POINTS == 0 and -one.cross(other) > SHARP
        # a node at a corner of the slave keeps to the segment that it faces
        if valley and (m < 0 or t.rival[q] == q):
            number, first, second = 2, _of_segment(t, before, 1.0), _of_segment(t, after, 0.0)
        elif not valley:
            between = x.at - node(t.sides.at.master, v)
            if between @ (one + other) < 0.0 and between.length() > depth:
                return count
            normal = (one + other).unit()
            if in_wedge(x.at, node(t.sides.at.master, v), one, other, t.master_length[after]):
                normal = between.unit()
            first = np.int64(after), 0.0, np.int64(-1 - v), normal.x, normal.y
    elif POINTS == 0:
        other, along = _second_side(t, x, q, m, reach, p)
        if other >= 0:
            number, second = 2, _of_segment(t, other, along)
    for slot in range(number):
        put_piece(t, count + slot, q, slot, first if slot == 0 else second)
    return count + number
