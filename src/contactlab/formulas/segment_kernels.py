"""Pieces of contact between segments: overlaps by an author's formula, and the integrals of its basis.

Slots: OVERLAP(slave, master, p) and BASIS(u, covered_low, covered_high, p), see `contactlab.api.segments`, with the
PARAMETERS p of an algorithm; PARTS, one more than the BREAKS at jumps of the basis; POINTS, WEIGHTS, a rule on 0 to 1
that is exact for the basis times straight traces, and a rule for quadratic traces; COVERED, True if the basis asks for
the total overlap.

Multipliers span a slave segment; multipliers at the ends of quadratic edges span the edge. u runs from 0 to 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import GapGradients, PieceDerivatives
from contactlab.api.compiled.bound_arrays import Floats2, Ints1
from contactlab.api.compiled.formulas import methods_of, slots
from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.records import column
from contactlab.api.compiled.unpack import unpack
from contactlab.api.mathematics import sqrt
from contactlab.api.segments import MasterSegment, SlaveSegment
from contactlab.api.tensors import Vector
from contactlab.formulas.segment_normals import Both, inward_normals, turn_normals

PARAMETERS, FIELDS = slots("PARAMETERS", "FIELDS")
# filled in `formulas.segments`, `_Kernels.formula_slots`: OVERLAP and BASIS are the method's own `overlap` and `basis`;
# of mortar-p0, whose basis jumps once, PARTS is 2 and BREAKS (1/2,); rules on straight edges have one point for it and
# two for mortar-p1
OVERLAP, BASIS, PARTS, BREAKS, COVERED = slots("OVERLAP", "BASIS", "PARTS", "BREAKS", "COVERED")
POINTS, WEIGHTS, QUADRATIC_POINTS, QUADRATIC_WEIGHTS = slots(
    "POINTS", "WEIGHTS", "QUADRATIC_POINTS", "QUADRATIC_WEIGHTS"
)
CUBIC_POINTS, CUBIC_WEIGHTS = slots("CUBIC_POINTS", "CUBIC_WEIGHTS")  # for smooth surfaces
SMALLEST = 1e-12  # overlaps shorter than this fraction of a slave segment are round-off
FLANK, FACING = 0.2, 0.3
"""Cosines of opposed normals: flanks of a corner, below the first, are no partners; from the second on
segments count in full, in between by a weight that grows evenly: a turning segment joins without a jump."""
NONE = np.uint32(0xFFFFFFFF)  # no node. Numbers without sign spare the test for places counted from the end


for _kind in (SlaveSegment, MasterSegment):
    methods_of(_kind)


class Derived(NamedTuple):
    """`Both` with the derivatives."""

    both: Both
    changes: PieceDerivatives


class Separated(NamedTuple):
    """`Both` with the owner and the separation of each multiplier, and the gradients."""

    both: Both
    owner: Ints1
    separation: Floats2
    gradients: GapGradients


@point
def no_parameters(numbers):
    """Return the parameters of an algorithm that has none."""
    return 0.0


@point
def parameters(numbers):
    """Return the parameters of an algorithm that has some."""
    return column(numbers, 0, FIELDS)


# --- geometry ---------------------------------------------------------------------------------------------------------


@point
def slave_segment(s, at, segments, inward):
    """Return segment s of the slave at positions (m, 2), with the inward normals (m, 2) of its nodes."""
    i, j = segments[s, 0], segments[s, 1]
    start, normal = Vector(at[i, 0], at[i, 1]), Vector(-inward[i, 0], -inward[i, 1])
    edge = Vector(at[j, 0] - start.x, at[j, 1] - start.y)
    return SlaveSegment(start, edge, normal, Vector(-inward[j, 0] - normal.x, -inward[j, 1] - normal.y))


@point
def master_segment(i, j, at):
    """Return the master segment from node i to node j."""
    return MasterSegment(Vector(at[i, 0], at[i, 1]), Vector(at[j, 0], at[j, 1]))


@point
def facing(slave, master):
    """Return the weight of an overlap of two segments: 1 if they face each other, 0 if one is a flank."""
    edge, other = slave.edge, master.edge()
    along, sizes = -(edge @ other), (edge @ edge) * (other @ other)
    weight = 1.0
    if along <= 0.0 or along * along <= FLANK * FLANK * sizes:
        weight = 0.0
    elif along * along < FACING * FACING * sizes:
        weight = (along / sqrt(sizes) - FLANK) / (FACING - FLANK)
    return weight


@point
def across(found, end, slave, master):
    """Return the vector from slave to master at an end of an overlap, and the gap along the slave's normal [mm]."""
    xi, eta = (found.low, found.eta_low) if end == 0 else (found.high, found.eta_high)
    apart, normal = master.at(eta) - slave.at(xi), slave.normal_at(xi)
    return apart, (apart @ normal) / normal.length()


@point
def tilt(slave, length):
    """Return the largest slope of the field of normals against the segment's own normal."""
    edge, n, o, least = slave.edge, slave.normal, slave.normal + slave.turn, 1e-3 * length
    a, upright = abs(n @ edge), max(abs(n.cross(edge)), least)
    b, beyond = abs(o @ edge), max(abs(o.cross(edge)), least)
    return max(a * beyond, b * upright) / (upright * beyond)


@point
def beside(slave, px, py):
    """Return the distances of (px, py) along the slave segment and from its line, times its length."""
    x, y = px - slave.start.x, py - slave.start.y
    return x * slave.edge.x + y * slave.edge.y, abs(x * slave.edge.y - y * slave.edge.x)


@point
def side(along, square, beyond):
    """Return -1 for a point before the range of the slave segment's normals, 1 for a point beyond, else 0."""
    return -1 if along < -beyond else (1 if along > square + beyond else 0)


# --- from overlaps to pieces ------------------------------------------------------------------------------------------


@section
def find_overlaps(both, s, reach, depth, begin, integrates, vertices, p):
    """Write pieces of slave segment s from `begin` on. Return the next free one.

    No piece if all are farther than `reach` [mm] or if the slave lies deeper than `depth` [mm]. Their weights
    are left in T until they are integrated.
    """
    view, out = both.sides, both.out
    surface, close, count = view.slave, False, begin
    slave = slave_segment(s, view.at.slave, surface.segments, out.normal)
    starts = surface.node_segments[surface.segments[s, 0], 0] < 0
    ends = surface.node_segments[surface.segments[s, 1], 1] < 0
    length = slave.edge.length()
    slope, square, near = tilt(slave, length), length * length, min(reach, depth) ** 2
    segments, at, last, d_along, d_away = view.master.segments, view.at.master, NONE, 0.0, 0.0
    for z in range(view.near.start[s], view.near.start[s + 1]):
        m = np.uint32(view.near.master[z])
        i, j = np.uint32(segments[m, 0]), np.uint32(segments[m, 1])
        c_along, c_away = d_along, d_away
        if i != last:
            c_along, c_away = beside(slave, at[i, 0], at[i, 1])
        d_along, d_away = beside(slave, at[j, 0], at[j, 1])
        last = j
        # outside the slave segment, both ends beyond the range of normals to the farther one. If normals lean by more
        # than 90 degrees it decides, too: a bound for each end by itself would skip flanks that a corner presses
        beyond = slope * max(c_away, d_away) + 1e-9 * square
        if side(c_along, square, beyond) * side(d_along, square, beyond) > 0:
            continue
        master = master_segment(i, j, at)
        weight = facing(slave, master)
        if not weight > 0.0:
            continue
        found = OVERLAP(slave, master, p)
        if not found.high - found.low > SMALLEST:
            continue
        first, low_gap = across(found, 0, slave, master)
        second, high_gap = across(found, 1, slave, master)
        gap = min(low_gap, high_gap)
        # the end of a chain slips past the end of the other, deeper behind it by twice what both overlap: that is the
        # far flank of a corner whose near flank carries the contact
        slips = -gap > 2.0 * (found.high - found.low) * length
        if slips and ((starts and found.low == 0.0) or (ends and found.high == 1.0)):
            continue
        if not max(first @ first, second @ second) <= near:
            if gap < -depth:
                continue
            close = close or gap <= reach
        else:
            close = True
        out.ends[count, 0], out.ends[count, 1] = found.low, min(1.0, max(0.0, found.eta_low))
        out.ends[count, 2], out.ends[count, 3] = found.high, min(1.0, max(0.0, found.eta_high))
        out.segment[count, 0], out.segment[count, 1] = s, m
        if integrates:
            put_piece(both, count, weight * length, 0.0, 1.0, vertices, p)
        else:
            out.T[count, 0, 0] = weight * length
        count += 1
    return count if close else begin


@point
def spans_edge(surface, vertices):
    """Return whether multipliers span quadratic edges rather than their halves."""
    return vertices and surface.edges.shape[1] == 3


@section
def put_nodes(view, s, m, p, vertices, slave, multiplier, master):
    """Write nodes and multipliers of slave segment s and master segment m into entry p of arrays as in `Pieces`."""
    own, other = view.slave, view.master
    edge, far = own.segment_edge[s, 0], other.segment_edge[m, 0]
    for i in range(own.edges.shape[1]):
        slave[p, i] = own.edges[edge, i]
    for i in range(other.edges.shape[1]):
        master[p, i] = other.edges[far, i]
    for k in range(2):
        multiplier[p, k] = own.edges[edge, k] if spans_edge(own, vertices) else own.segments[s, k]


@section
def put_piece(both, p, length, low, high, vertices, fields):
    """Write piece p; `length` [mm]: weighted, of its slave segment; `low`, `high`: total overlap of its span."""
    view, out = both.sides, both.out
    s, m = out.segment[p, 0], out.segment[p, 1]
    if out.D.shape[1] == 2 and out.M.shape[1] == 2:
        for k in range(2):
            out.slave[p, k] = out.multiplier[p, k] = view.slave.segments[s, k]
            out.master[p, k] = view.master.segments[m, k]
        integrate_straight(out, p, length, low, high, fields)
        return
    put_nodes(view, s, m, p, vertices, out.slave, out.multiplier, out.master)
    half = view.slave.segment_edge[s, 1]
    begin, share = (0.5 * half, 0.5) if spans_edge(view.slave, vertices) else (0.0, 1.0)
    integrate(out, p, length, (half, view.master.segment_edge[m, 1]), (begin, share), (low, high), fields)


@section
def integrate_covered(both, count, vertices, fields):
    """Integrate the pieces, whose weighted lengths are in T, with the total overlap of their spans."""
    view, out = both.sides, both.out
    whole = spans_edge(view.slave, vertices)
    p = 0
    while p < count:
        span, last, low, high = span_of(view.slave, out.segment[p, 0], whole), p, 1.0, 0.0
        while last < count and span_of(view.slave, out.segment[last, 0], whole) == span:
            at, share = place_in_span(view.slave, out.segment[last, 0], whole)
            low, high = min(low, at + share * out.ends[last, 0]), max(high, at + share * out.ends[last, 2])
            last += 1
        for q in range(p, last):
            put_piece(both, q, out.T[q, 0, 0], low, high, vertices, fields)
        p = last


@point
def span_of(surface, s, whole):
    """Return the span of the multipliers of segment s: the number of its edge, or its own."""
    return surface.segment_edge[s, 0] if whole else np.int32(s)


@point
def place_in_span(surface, s, whole):
    """Return the start of segment s in the span of its multipliers, and its share of the span."""
    return (0.5 * surface.segment_edge[s, 1], 0.5) if whole else (0.0, 1.0)


@kernel
def pieces(bound, reach, depth, vertices):
    """Fill the pieces of a `Both` at the address `bound`. Return their number, and how many normals are not averaged.

    depth     [longest segments of the slave]
    vertices  multipliers of quadratic slave edges belong to their ends alone
    """
    both, count = unpack(bound, Both), 0
    view, out, p = both.sides, both.out, PARAMETERS(both.numbers)
    depth *= inward_normals(view.at.slave, view.slave.segments, out.normal)
    for s in range(view.slave.segments.shape[0]):
        if view.near.start[s] < view.near.start[s + 1]:
            count = find_overlaps(both, s, reach, depth, count, not COVERED, vertices, p)
    if COVERED:
        integrate_covered(both, count, vertices, p)
    return count, turn_normals(view, out, count, out.normal)


# --- integrals --------------------------------------------------------------------------------------------------------


@point
def trace(nodes, half, xi, i):
    """Return shape function i of an edge with `nodes` nodes at xi in [0, 1] of its straight segment `half`."""
    if nodes == 2:
        return 1.0 - xi if i == 0 else xi
    s = xi + half - 1.0
    if i == 0:
        return 0.5 * s * (s - 1.0)
    if i == 1:
        return 0.5 * s * (s + 1.0)
    return 1.0 - s * s


@point
def cut(low, high, part, begin, share):
    """Return the part of an overlap between two breaks of the basis; its end is before its start if it is empty."""
    if part > 0:
        low = max(low, (BREAKS[part - 1] - begin) / share)
    if part < PARTS - 1:
        high = min(high, (BREAKS[part] - begin) / share)
    return low, high


@section
def integrate_straight(out, p, length, covered_low, covered_high, fields):
    """Fill piece p for edges of two nodes: exactly, with as many points as the basis needs."""
    low, eta_low, high, eta_high = out.ends[p, 0], out.ends[p, 1], out.ends[p, 2], out.ends[p, 3]
    slope = (eta_high - eta_low) / (high - low)
    t00, t01, t10, t11, m00, m01, m10, m11 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for part in range(PARTS):
        begin, end = cut(low, high, part, 0.0, 1.0)
        if end > begin:
            for g in range(len(POINTS)):
                xi = begin + POINTS[g] * (end - begin)
                eta, weight = eta_low + (xi - low) * slope, WEIGHTS[g] * (end - begin) * length
                first, second = BASIS(xi, covered_low, covered_high, fields)
                first, second = weight * first, weight * second
                t00, t01, t10, t11 = (
                    t00 + (1.0 - xi) * first,
                    t01 + (1.0 - xi) * second,
                    t10 + xi * first,
                    t11 + xi * second,
                )
                m00, m01 = m00 + (1.0 - eta) * first, m01 + (1.0 - eta) * second
                m10, m11 = m10 + eta * first, m11 + eta * second
    D, M, T = out.D, out.M, out.T
    D[p, 0, 0], D[p, 0, 1], D[p, 1, 0], D[p, 1, 1] = t00, t01, t10, t11
    T[p, 0, 0], T[p, 0, 1], T[p, 1, 0], T[p, 1, 1] = t00, t01, t10, t11
    M[p, 0, 0], M[p, 0, 1], M[p, 1, 0], M[p, 1, 1] = m00, m01, m10, m11


@section
def integrate(out, p, length, halves, span, covered, fields):
    """Fill piece p of edges with any traces; halves: position of the segments in both edges."""
    D, M, T = out.D, out.M, out.T
    D[p], M[p], T[p] = 0.0, 0.0, 0.0
    low, eta_low, high, eta_high = out.ends[p, 0], out.ends[p, 1], out.ends[p, 2], out.ends[p, 3]
    slope = (eta_high - eta_low) / (high - low)
    for part in range(PARTS):
        begin, end = cut(low, high, part, span[0], span[1])
        if end > begin:
            for g in range(len(QUADRATIC_POINTS)):
                xi = begin + QUADRATIC_POINTS[g] * (end - begin)
                eta, u = eta_low + (xi - low) * slope, span[0] + span[1] * xi
                weight = QUADRATIC_WEIGHTS[g] * (end - begin) * length
                first, second = BASIS(u, covered[0], covered[1], fields)
                for k in range(2):
                    psi = weight * (first if k == 0 else second)
                    for i in range(D.shape[1]):
                        D[p, i, k] += psi * trace(D.shape[1], halves[0], xi, i)
                    for i in range(M.shape[1]):
                        M[p, i, k] += psi * trace(M.shape[1], halves[1], eta, i)
                    T[p, 0, k] += psi * (1.0 - u)
                    T[p, 1, k] += psi * u
