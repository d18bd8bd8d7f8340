"""Contact at points: the master segment or vertex in contact with each node, or Gauss point, of the slave.

Slots as in `point_pieces` and PARAMETERS as in `segment_kernels`; HOLD, `hold_nodes` or `hold_gauss_points`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import GapGradients, PieceDerivatives, Pieces
from contactlab.api.compiled.bound_arrays import Flags1, Floats1, Floats2, Ints1
from contactlab.api.compiled.chains import nodal_normals, segment_normals, tributary_lengths
from contactlab.api.compiled.formulas import slots
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.segments import SlavePoint
from contactlab.api.tensors import Vector
from contactlab.formulas.point_corners import find_corners, put_corners, stands_for
from contactlab.formulas.point_pieces import ABSCISSAE, ALONE, EDGE, LEAVE, POINTS, SHARP, faces, foot, hold, kink
from contactlab.formulas.segment_kernels import PARAMETERS, trace
from contactlab.formulas.segment_normals import View, inward_normals, node, turn_normals

(HOLD,) = slots("HOLD")
FLANK = 0.2  # cosine: the gap of a Gauss point counts along the slave's normal, unlike its projection
HYSTERESIS = 1.02  # a new segment must be nearer by this factor: stops flicker at corners


class Points(NamedTuple):
    """A view, its pieces, and arrays for measures of both surfaces.

    In pieces at points, `segment` has the point (the node, or the Gauss point's number along the slave; under a
    corner of the master -1 less the slave's segment) and its contact (the master's segment; -1 less the vertex).
    `ends` has xi of the point in its segment, eta of its projection, and a flag for s, -1 to 1, on a quadratic edge.

    numbers    (n, 1) the numbers among the fields of the algorithm
    memory     of nodes: the segment plus one, 0 for none; the corner plus one. Of Gauss points: the segment plus one
    slave_normal, slave_length    of slave segments (s, 2), (s,) [mm]
    master_normal, master_length  of master segments
    outward    (m, 2) averaged normals of slave nodes
    tributary  (m,) [mm] the length of slave surface of each node
    rival      (m,) the same node on the other flank of a corner of the slave, elsewhere the slave node itself
    taken      (m,) True if a slave node has two constraints of its own
    carried    (m,) the corner whose constraint a slave node carries plus one, 0 for none
    corner_on, corner_share  (l,) the slave segment that each corner of the master presses on, -1 for none; share on it
    psi        (k,) [mm] weights of the multipliers at the present point
    """

    sides: View
    out: Pieces
    numbers: Floats2
    memory: Floats2
    slave_normal: Floats2
    slave_length: Floats1
    master_normal: Floats2
    master_length: Floats1
    outward: Floats2
    tributary: Floats1
    rival: Ints1
    taken: Flags1
    carried: Ints1
    corner_on: Ints1
    corner_share: Floats1
    psi: Floats1


class DerivedPoints(NamedTuple):
    """`Points` with the derivatives."""

    points: Points
    changes: PieceDerivatives


class TurnedPoints(NamedTuple):
    """`Points` with the gradients."""

    points: Points
    gradients: GapGradients


# --- both surfaces ----------------------------------------------------------------------------------------------------


@kernel
def node_lengths(positions, surface, lengths, out):
    """Compute the length [mm] of each slave node: half of its edges, or 1/6, 4/6 and 1/6 of a quadratic edge.

    These are the integrals of the edge's own shape functions: the nodal weights of a constant pressure. `surface` is a
    `SurfaceTable`, `lengths` (s,) [mm] belong to its segments.
    """
    edges, segment_edge = surface.edges, surface.segment_edge
    if edges.shape[1] == 2:
        tributary_lengths(positions, surface.segments, surface.node_segments, out)
        return
    for i in range(out.size):
        out[i] = 0.0
    for s in range(lengths.size):
        share = lengths[s] / 6.0
        edge = segment_edge[s, 0]
        out[edges[edge, 0]] += share
        out[edges[edge, 1]] += share
        out[edges[edge, 2]] += 4.0 * share


@section
def measure(t):
    """Compute normals and lengths of both surfaces. Return the longest segment of both [mm]."""
    slave, master, at = t.sides.slave, t.sides.master, t.sides.at
    segment_normals(at.slave, slave.segments, t.slave_normal, t.slave_length)
    nodal_normals(slave.node_segments, t.slave_normal, t.slave_length, t.outward)
    node_lengths(at.slave, slave, t.slave_length, t.tributary)
    segment_normals(at.master, master.segments, t.master_normal, t.master_length)
    longest = 0.0
    for m in range(t.master_length.size):
        longest = max(longest, t.master_length[m])
    for s in range(t.slave_length.size):
        longest = max(longest, t.slave_length[s])
    return longest


@section
def gauss_point(t, s, xi):
    """Return the point at xi of slave segment s, on its parabola if edges are quadratic."""
    surface, at = t.sides.slave, t.sides.at.slave
    edge, half, nodes = surface.segment_edge[s, 0], surface.segment_edge[s, 1], surface.edges.shape[1]
    i, j = surface.segments[s, 0], surface.segments[s, 1]
    x, y = 0.0, 0.0
    for k in range(nodes):
        share = trace(nodes, half, xi, k)
        x, y = x + share * at[surface.edges[edge, k], 0], y + share * at[surface.edges[edge, k], 1]
    return SlavePoint(Vector(x, y), (1.0 - xi) * node(t.outward, i) + xi * node(t.outward, j))


# --- the nearest ------------------------------------------------------------------------------------------------------


@section
def _beyond(t, m, side, s):
    """Return how far a point of slave segment s may project beyond end 0 or 1 of master segment m, in lengths of m.

    A node beyond the end in a sharp valley has sunk into the next segment: it has the same limit as at a free end.
    """
    surface = t.sides.master
    other = surface.node_segments[surface.segments[m, side], side]
    if other < 0:
        return LEAVE * min(1.0, t.slave_length[s] / t.master_length[m])
    first, second = (other, m) if side == 0 else (m, other)
    return LEAVE if POINTS == 0 and kink(t, first, second) < -SHARP else EDGE


@section
def nearest_segment(t, x, q, s, last, best, reach, depth, p):
    """Return the nearer of `best` (segment, eta, distance) and the projection of point q near slave segment s."""
    view, (found, share, nearest) = t.sides, best
    for z in range(view.near.start[s], view.near.start[s + 1]):
        m = view.near.master[z]
        if not faces(t, x, q, m, FLANK if POINTS > 0 else 0.0):
            continue
        gap, eta = foot(t, x, m, p)
        if gap > reach or gap < -depth:
            continue
        if not (eta >= -_beyond(t, m, 0, s) and eta <= 1.0 + _beyond(t, m, 1, s)):
            continue
        distance = abs(gap) * (1.0 if m == last else HYSTERESIS)
        if distance < nearest:
            found, share, nearest = m, min(1.0, max(0.0, eta)), distance
    return found, share, nearest


@section
def nearest_vertex(t, x, s, best, reach, p):
    """Return the nearer of `best` (vertex, distance) and the vertices between two segments near slave segment s.

    Only a point beyond both segments is in contact with the vertex between them.
    """
    view, (found, nearest) = t.sides, best
    for z in range(view.near.start[s], view.near.start[s + 1]):
        after = view.near.master[z]
        v = view.master.segments[after, 0]
        before = view.master.node_segments[v, 0]
        if before < 0:
            continue
        nx = t.master_normal[before, 0] + t.master_normal[after, 0]
        ny = t.master_normal[before, 1] + t.master_normal[after, 1]
        between = x.at - node(view.at.master, v)
        distance = between.length()
        if not (x.normal.x * nx + x.normal.y * ny < 0.0 and distance <= reach and distance < nearest):
            continue
        if POINTS > 0 and abs(x.normal @ between) < FLANK * distance:
            continue
        if not (foot(t, x, before, p)[1] >= 1.0 - EDGE and foot(t, x, after, p)[1] <= EDGE):
            continue  # next to an end of the chain, or on a flank that does not face the point
        found, nearest = v, distance
    return found, nearest


# --- all points -------------------------------------------------------------------------------------------------------


@section
def hold_nodes(t, reach, depth, p):
    """Write pieces of all slave nodes and of master corners. Return their number, and 0: all normals are their own."""
    view, taken = t.sides, t.taken
    corners, count = find_corners(t, reach, depth), 0
    for i in range(view.at.slave.shape[0]):
        x = SlavePoint(node(view.at.slave, i), node(t.outward, i))
        best, before, last = (np.int64(-1), 0.0, np.inf), count, int(t.memory[0, i]) - 1
        for side in range(2):
            if view.slave.node_segments[i, side] >= 0:
                best = nearest_segment(t, x, i, view.slave.node_segments[i, side], last, best, reach, depth, p)
        m, vertex = best[0], (np.int64(-1), np.inf)
        t.memory[0, i] = m + 1
        if m < 0:
            for side in range(2):
                if view.slave.node_segments[i, side] >= 0:
                    vertex = nearest_vertex(t, x, view.slave.node_segments[i, side], vertex, reach, p)
        v = vertex[0]
        if not (m < 0 and v < 0) and not (corners and stands_for(t, i, m, v)):
            count = hold(t, count, x, i, best[:2], v, reach, depth, p)
        taken[i] = count - before > 1
    return put_corners(t, count, taken), 0


@section
def hold_gauss_points(t, reach, depth, p):
    """Write pieces of all Gauss points of the slave. Return their number, and the number of normals not averaged."""
    view, count = t.sides, 0
    for s in range(t.slave_length.size):
        i = view.slave.segments[s, 0]
        for g in range(len(ABSCISSAE)):
            x, last, q = gauss_point(t, s, ABSCISSAE[g]), int(t.memory[g, i]) - 1, s * POINTS + g
            best, v = nearest_segment(t, x, q, s, last, (np.int64(-1), 0.0, np.inf), reach, depth, p), np.int64(-1)
            t.memory[g, i] = best[0] + 1
            if best[0] < 0:
                v = nearest_vertex(t, x, s, (np.int64(-1), np.inf), reach, p)[0]
            if best[0] >= 0 or v >= 0:
                count = hold(t, count, x, q, best[:2], v, reach, depth, p)
    if ALONE:
        return count, 1
    inward_normals(view.at.slave, view.slave.segments, t.out.normal)
    return count, turn_normals(view, t.out, count, t.out.normal)


@kernel
def pieces(bound, reach, depth):
    """Fill a piece per contact point (two at sharp concave corners). Return their number, and turned normals.

    `bound` is the address of a `Points`. Points farther than `reach` [mm] or deeper than `depth` of the longest
    segment have no contact.
    """
    t = unpack(bound, Points)
    return HOLD(t, reach, depth * measure(t), PARAMETERS(t.numbers))
