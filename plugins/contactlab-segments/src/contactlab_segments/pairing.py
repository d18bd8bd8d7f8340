"""Which master segment, or vertex, holds each slave node."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.chains import nodal_normals, segment_normals
from contactlab.api.compiled.kernel import section, table_kernel
from contactlab.api.compiled.unpack import unpack
from contactlab_segments.corners import find_corners, held_by_corner, put_corners
from contactlab_segments.holding import SHARP, hold_at_vertex, put_on_parabola, put_piece
from contactlab_segments.tables import PairingTable
from contactlab_segments.weights import node_lengths

EDGE = 1e-9  # how far, in segment lengths, a node may project beyond a segment's end
LEAVE = 0.02  # the same at the ends of a chain, where nothing else holds it: bodies of one width spread differently
AT_END = 1e-6  # shares of a segment end within which a node sits on the vertex
HYSTERESIS = 1.02  # a new segment must be nearer by this factor: stops flicker at corners


@section
def _measure(t):
    """Normals and lengths of both surfaces; returns the longest master segment [mm]."""
    slave, master = t.slave, t.master
    segment_normals(t.slave_at, slave.segments, t.slave_normal, t.slave_length)
    nodal_normals(slave.node_segments, t.slave_normal, t.slave_length, t.outward)
    node_lengths(t.slave_at, slave, t.slave_length, t.tributary)
    segment_normals(t.master_at, master.segments, t.master_normal, t.master_length)
    longest = 0.0
    for m in range(t.master_length.size):
        longest = max(longest, t.master_length[m])
    return longest


@section
def _foot(t, i, m):
    """Gap [mm] and xi of slave node i on the line of master segment m."""
    a, b = t.master.segments[m, 0], t.master.segments[m, 1]
    dx, dy = t.slave_at[i, 0] - t.master_at[a, 0], t.slave_at[i, 1] - t.master_at[a, 1]
    gap = dx * t.master_normal[m, 0] + dy * t.master_normal[m, 1]
    along = dx * (t.master_at[b, 0] - t.master_at[a, 0]) + dy * (t.master_at[b, 1] - t.master_at[a, 1])
    return gap, along / (t.master_length[m] * t.master_length[m])


@section
def _beyond(t, m, side):
    """How far a node may project beyond an end (0 or 1) of a segment."""
    return EDGE if t.master.node_segments[t.master.segments[m, side], side] >= 0 else LEAVE


@section
def _nearest_segment(t, i, reach, depth):
    """Nearest segment that slave node i projects onto and xi there; -1 if there is none."""
    found, share, nearest, last = -1, 0.0, np.inf, int(t.memory[0, i]) - 1
    for side in range(2):
        s = t.slave.node_segments[i, side]
        if s < 0:
            continue
        for z in range(t.start[s], t.start[s + 1]):
            m = t.candidates[z]
            if t.outward[i, 0] * t.master_normal[m, 0] + t.outward[i, 1] * t.master_normal[m, 1] >= 0.0:
                continue
            gap, xi = _foot(t, i, m)
            if gap > reach or gap < -depth or xi < -_beyond(t, m, 0) or xi > 1.0 + _beyond(t, m, 1):
                continue
            measure = abs(gap) * (1.0 if m == last else HYSTERESIS)
            if measure < nearest:
                found, share, nearest = m, min(1.0, max(0.0, xi)), measure
    return found, share


@section
def _nearest_vertex(t, i, reach):
    """Nearest vertex between two segments to slave node i, which projects onto neither; -1 if there is none."""
    found, nearest = -1, np.inf
    for side in range(2):
        s = t.slave.node_segments[i, side]
        if s < 0:
            continue
        for z in range(t.start[s], t.start[s + 1]):
            after = t.candidates[z]
            v = t.master.segments[after, 0]
            before = t.master.node_segments[v, 0]
            if before < 0:
                continue
            nx = t.master_normal[before, 0] + t.master_normal[after, 0]
            ny = t.master_normal[before, 1] + t.master_normal[after, 1]
            dx, dy = t.slave_at[i, 0] - t.master_at[v, 0], t.slave_at[i, 1] - t.master_at[v, 1]
            distance = np.sqrt(dx * dx + dy * dy)
            if t.outward[i, 0] * nx + t.outward[i, 1] * ny < 0.0 and distance <= reach and distance < nearest:
                found, nearest = v, distance
    return found


@section
def _end_reached(t, m, share):
    """The vertex that a node sits on, -1 elsewhere: there neither segment's normal is better than the other's."""
    if share > AT_END and share < 1.0 - AT_END:
        return -1
    v = t.master.segments[m, 0] if share <= AT_END else t.master.segments[m, 1]
    return v if t.master.node_segments[v, 0] >= 0 and t.master.node_segments[v, 1] >= 0 else -1


@section
def _second_side(t, i, m, reach):
    """The neighbour that holds node i too, and xi there: i is in a sharp concave corner and projects onto both."""
    for side in range(2):
        other = t.master.node_segments[t.master.segments[m, side], side]
        if other < 0:
            continue
        first, second = (m, other) if side == 1 else (other, m)
        turn = t.master_normal[first, 0] * t.master_normal[second, 1]
        turn -= t.master_normal[first, 1] * t.master_normal[second, 0]
        if turn > -SHARP:
            continue
        gap, along = _foot(t, i, other)
        if -EDGE <= along <= 1.0 + EDGE and abs(gap) <= reach:
            return other, along
    return -1, 0.0


@section
def _hold_on_segment(t, count, i, m, share, reach, depth):
    """Write what segment m, or what lies at its ends, holds node i with; returns the next piece."""
    if t.master.edges.shape[1] == 3:
        put_on_parabola(t, count, i, t.master.segment_edge[m, 0], share + t.master.segment_edge[m, 1] - 1.0)
        return count + 1
    v = _end_reached(t, m, share)
    if v >= 0:
        return hold_at_vertex(t, count, i, v, depth)
    put_piece(t, count, i, 0, m, share, t.master_normal[m])
    other, xi = _second_side(t, i, m, reach)
    if other < 0:
        return count + 1
    put_piece(t, count + 1, i, 1, other, xi, t.master_normal[other])
    return count + 2


@section
def _hold_beside(t, count, i, v, depth):
    """Write what vertex v holds node i with; returns the next piece."""
    after = t.master.node_segments[v, 1]
    if t.master.edges.shape[1] == 3 and t.master.segment_edge[after, 1] == 1:
        # beside the kink of two half segments, where the true edge is smooth
        put_on_parabola(t, count, i, t.master.segment_edge[after, 0], 0.0)
        return count + 1
    return hold_at_vertex(t, count, i, v, depth)


@table_kernel
def pair_nodes(bound, reach, depth):
    """Fill one piece per held node (two at sharp concave corners); returns their number.

    `bound` is the address of a `PairingTable`. Nodes farther than `reach` [mm] or deeper than `depth` of the longest
    master segment are held by none.
    """
    t = unpack(bound, PairingTable)
    depth *= _measure(t)
    corners, count = find_corners(t, reach, depth), 0
    taken = t.taken
    for i in range(t.slave_at.shape[0]):
        m, share = _nearest_segment(t, i, reach, depth)
        t.memory[0, i], before = m + 1, count
        if m >= 0:
            if not (corners and held_by_corner(t, i, m)):
                count = _hold_on_segment(t, count, i, m, share, reach, depth)
        else:
            v = _nearest_vertex(t, i, reach)
            if v >= 0 and not (corners and t.corner_on[v] >= 0):
                count = _hold_beside(t, count, i, v, depth)
        taken[i] = count - before > 1
    return put_corners(t, count, taken)
