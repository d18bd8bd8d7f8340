"""Corners and ends of the master as points that stay outside the slave's segments.

A node of the slave on a flank near a corner is pressed along the flank's normal, and friction leans with
it; a corner between two nodes is not held at all. So if no flank of a corner leads into the slave, the corner itself
is pressed along the normal of the slave's segment. So is the deepest vertex of an arc that turns within a segment:
between two nodes it would sink in by an eighth of the segment times its turn, and the next node would catch behind it.
All sections work on a `Points` table t; v is the corner.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import point, section
from contactlab.formulas.point_pieces import EDGE, LEAVE
from contactlab.formulas.segment_normals import node

CORNER = 0.5  # sine by which a master turns outward at a corner
ARC = 0.42  # sine of the turn of an arc, over a slave segment; from 0.25 on rims of dented masters would count
WITHIN = 0.99  # slave segments: in meshes that match, each segment of the slave sees one vertex
RISE = -0.05
CLOSE = 0.05  # of a segment: a slave node this near a corner has no further constraint


@point
def _turns(one, other, least):
    """Return whether a surface turns outward between two normals by more than the sine `least`."""
    turn = one.cross(other)
    return turn > least or (turn > 0.0 and one @ other < 0.0)


@section
def _rounded(t, v, one, other, s):
    """Return whether node v is the deepest of an arc that turns like a corner within the length of slave segment s.

    Two neighbours are, if their connection is parallel to the segment up to a quarter of a turn.
    """
    surface, facing, tie = t.sides.master, node(t.slave_normal, s), -min(-RISE, 0.25 * one.cross(other))
    if not (facing.cross(one) >= tie and other.cross(facing) >= tie):
        return False
    for side in range(2):
        m, way = surface.node_segments[v, side], t.master_length[surface.node_segments[v, side]]
        while way < WITHIN * t.slave_length[s]:
            m = surface.node_segments[surface.segments[m, side], side]
            if m < 0:
                break
            way += t.master_length[m]
            end = node(t.master_normal, m)
            if _turns(end, other, ARC) if side == 0 else _turns(one, end, ARC):
                return True
    return False


@section
def _is_corner(t, v, s):
    """Return whether the master ends or turns outward at its node v, seen from slave segment s."""
    before, after = t.sides.master.node_segments[v, 0], t.sides.master.node_segments[v, 1]
    if before < 0 or after < 0:
        return True
    one, other = node(t.master_normal, before), node(t.master_normal, after)
    return _turns(one, other, CORNER) or (one.cross(other) > 0.0 and _rounded(t, v, one, other, s))


@point
def _outside(t, s, v):
    """Return the distance [mm] of master node v outside slave segment s."""
    a = t.sides.slave.segments[s, 0]
    return (node(t.sides.at.master, v) - node(t.sides.at.slave, a)) @ node(t.slave_normal, s)


@point
def _within(t, s, side, z):
    """Return the least distance of corner `z` = (v, m) from an end (0 or 1) of slave segment s, in its lengths.

    If slave and master both end, it is the distance beyond master segment m up to which the last slave node is held:
    sides with coincident ends would otherwise switch with every correction.
    """
    v, m = z
    ends = t.sides.slave.node_segments[t.sides.slave.segments[s, side], side] < 0
    if not ends or (t.sides.master.node_segments[v, 0] >= 0 and t.sides.master.node_segments[v, 1] >= 0):
        return -EDGE
    return LEAVE * min(1.0, t.master_length[m] / t.slave_length[s])


@section
def _rises(t, s, v, gap):
    """Return whether the flanks of corner v face slave segment s on average and lead away from it."""
    facing = 0.0
    for side in range(2):
        m = t.sides.master.node_segments[v, side]
        if m < 0:
            continue
        facing += node(t.master_normal, m) @ node(t.slave_normal, s)
        if not _outside(t, s, t.sides.master.segments[m, side]) - gap > RISE * t.master_length[m]:
            return False
    return facing < 0.0


@section
def find_corners(t, reach, depth):
    """Find the slave segment that each corner of the master presses on. Return whether there is any.

    Marks in `t.carried` the nodes near a corner.
    """
    for v in range(t.corner_on.size):
        t.corner_on[v] = -1
    for i in range(t.carried.size):
        t.carried[i] = 0
    found = False
    for s in range(t.sides.slave.segments.shape[0]):
        for z in range(t.sides.near.start[s], t.sides.near.start[s + 1]):
            for end in range(2):
                v = t.sides.master.segments[t.sides.near.master[z], end]
                if not _is_corner(t, v, s):
                    continue
                gap = _outside(t, s, v)
                if gap > reach or gap < -depth:
                    continue
                a, b = t.sides.slave.segments[s, 0], t.sides.slave.segments[s, 1]
                start = node(t.sides.at.slave, a)
                along = (node(t.sides.at.master, v) - start) @ (node(t.sides.at.slave, b) - start)
                share = along / (t.slave_length[s] * t.slave_length[s])
                at = (v, t.sides.near.master[z])
                if share < _within(t, s, 0, at) or share > 1.0 - _within(t, s, 1, at) or not _rises(t, s, v, gap):
                    continue
                if t.corner_on[v] < 0 or abs(gap) < abs(_outside(t, t.corner_on[v], v)):
                    t.corner_on[v], t.corner_share[v], found = s, share, True
    for v in range(t.corner_on.size if found else 0):
        s, share = t.corner_on[v], t.corner_share[v]
        if s >= 0 and (share < CLOSE or share > 1.0 - CLOSE):
            t.carried[t.sides.slave.segments[s, 0 if share < CLOSE else 1]] = v + 1
    return found


@section
def put_corners(t, count, taken):
    """Write the pieces of corners from `count` on. Return the next. `taken` (m,) marks nodes with two constraints."""
    out, m = t.out, t.sides.at.slave.shape[0]
    for i in range(m):
        t.carried[i] = 0
    for v in range(t.corner_on.size):
        s = t.corner_on[v]
        if s < 0:
            continue
        share, a, b = t.corner_share[v], t.sides.slave.segments[s, 0], t.sides.slave.segments[s, 1]
        i = a if share < 0.5 else b
        if t.memory[1, a + b - i] == v + 1:  # it stays with its node within a segment: forces belong to nodes
            i = a + b - i
        if taken[i]:
            i = b if i == a else a
        if taken[i]:
            continue
        taken[i], t.carried[i] = True, v + 1
        weight, k, side = t.tributary[i], m + i, 0 if t.sides.master.node_segments[v, 1] < 0 else 1
        out.slave[count, 0], out.slave[count, 1], out.multiplier[count, 0] = a, b, k
        out.D[count, 0, 0], out.D[count, 1, 0], out.T[count, 0, 0] = (1.0 - share) * weight, share * weight, weight
        other = t.sides.master.segments[t.sides.master.node_segments[v, side], side]
        for r in range(out.M.shape[1]):
            out.master[count, r], out.M[count, r, 0] = other, 0.0
        out.master[count, 0], out.M[count, 0, 0] = v, weight
        out.segment[count, 0], out.segment[count, 1] = -1 - s, -1 - v
        out.ends[count, 0], out.ends[count, 1], out.ends[count, 2] = share, 0.0, 0.0
        out.normal[k, 0], out.normal[k, 1] = -t.slave_normal[s, 0], -t.slave_normal[s, 1]
        count += 1
    for i in range(m):
        t.memory[1, i] = t.carried[i]
    return count


@point
def stands_for(t, i, m, v):
    """Return whether a corner that presses on the slave replaces the contact of node i.

    It is near the node, which is in contact with master segment m, or, if m is negative, vertex v.
    """
    return t.corner_on[v] >= 0 if m < 0 else t.carried[i] > 0
