"""Derivatives of the pieces of contact between segments by node positions, by dual numbers in two stages.

Overlap ends of a piece, and its weighted length, depend on twelve coordinates: the ends of its slave segment
and their neighbours, by the averaged normals, and the ends of its master segment. D, M and T depend on these and
on the total overlap of the span of the multipliers, six quantities; they grow with the length. So no formula is
differentiated by more than twelve directions, whatever the edges. The total overlap ends at the ends of other pieces:
it adds their nodes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contactlab.api.compiled.dual import derivatives, seed, value
from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.segments import MasterSegment, SlaveSegment
from contactlab.api.tensors import Vector
from contactlab.formulas.segment_kernels import (
    BASIS,
    COVERED,
    OVERLAP,
    PARAMETERS,
    PARTS,
    QUADRATIC_POINTS,
    QUADRATIC_WEIGHTS,
    Derived,
    Separated,
    cut,
    facing,
    place_in_span,
    put_nodes,
    span_of,
    spans_edge,
)
from contactlab.formulas.segment_normals import average_derivatives, inward_normals, normal_derivatives

MOST_NODES = 12  # of a piece and of the pieces at the ends of the total overlap: five of the slave, six of the master
NUMBERS = 7  # that integrals depend on: six quantities, and the logarithm of the length
LOW, HIGH, ETA_LOW, ETA_HIGH, LENGTH = 0, 1, 2, 3, 4  # rows of rates
COVERED_LOW, COVERED_HIGH = 4, 5  # further directions of the integrals


# --- ends and lengths by positions ------------------------------------------------------------------------------------


@section
def nodes_of(view, s, m, out):
    """Fill nodes of a piece of segments s and m, first the slave's, then the master's; -1 without one."""
    segments, node_segments, shift = view.slave.segments, view.slave.node_segments, view.at.slave.shape[0]
    i, j = segments[s, 0], segments[s, 1]
    before, after = node_segments[i, 0], node_segments[j, 1]
    out[0] = segments[before, 0] if before >= 0 else -1
    out[1], out[2] = i, j
    out[3] = segments[after, 1] if after >= 0 else -1
    out[4], out[5] = shift + view.master.segments[m, 0], shift + view.master.segments[m, 1]


@point
def differentiated(view, nodes):
    """Return the slave and the master segment of six nodes, by their twelve coordinates."""
    x, y, shift = view.at.slave, view.at.master, view.at.slave.shape[0]
    i, j, c, d = nodes[1], nodes[2], nodes[4] - shift, nodes[5] - shift
    a, b = Vector(seed(x[i, 0], 2, 12), seed(x[i, 1], 3, 12)), Vector(seed(x[j, 0], 4, 12), seed(x[j, 1], 5, 12))
    before, after = a, b
    if nodes[0] >= 0:
        before = Vector(seed(x[nodes[0], 0], 0, 12), seed(x[nodes[0], 1], 1, 12))
    if nodes[3] >= 0:
        after = Vector(seed(x[nodes[3], 0], 6, 12), seed(x[nodes[3], 1], 7, 12))
    normal, other = (b - before).turned().unit(), (after - a).turned().unit()
    master = MasterSegment(
        Vector(seed(y[c, 0], 8, 12), seed(y[c, 1], 9, 12)), Vector(seed(y[d, 0], 10, 12), seed(y[d, 1], 11, 12))
    )
    return SlaveSegment(a, b - a, normal, other - normal), master


@point
def put_row(rates, row, changes):
    """Write a row of twelve derivatives."""
    for j in range(12):
        rates[row, j] = changes[j]


@section
def find_rates(view, out, count, fields, nodes, rates, lengths):
    """Compute for each piece its nodes (p, 6), weighted length (p,), and rates of its ends and logarithmic length.

    rates (p, 5, 12): low, high, eta_low, eta_high and the length by the twelve coordinates
    """
    for p in range(count):
        nodes_of(view, out.segment[p, 0], out.segment[p, 1], nodes[p])
        slave, master = differentiated(view, nodes[p])
        found = OVERLAP(slave, master, fields)
        length = facing(slave, master) * slave.edge.length()
        put_row(rates[p], LOW, derivatives(found.low, 12))
        put_row(rates[p], HIGH, derivatives(found.high, 12))
        put_row(rates[p], ETA_LOW, derivatives(found.eta_low, 12))
        put_row(rates[p], ETA_HIGH, derivatives(found.eta_high, 12))
        put_row(rates[p], LENGTH, derivatives(length / value(length), 12))
        lengths[p] = value(length)


@section
def find_covered(view, out, count, vertices, first, last, covered):
    """Find the pieces (p,) at both ends of the total overlap of each piece's span, and its ends (p, 2)."""
    whole, p = spans_edge(view.slave, vertices), 0
    while p < count:
        span, end, lowest, highest, low, high = span_of(view.slave, out.segment[p, 0], whole), p, p, p, 1.0, 0.0
        while end < count and span_of(view.slave, out.segment[end, 0], whole) == span:
            at, share = place_in_span(view.slave, out.segment[end, 0], whole)
            if at + share * out.ends[end, 0] < low:
                low, lowest = at + share * out.ends[end, 0], end
            if at + share * out.ends[end, 2] > high:
                high, highest = at + share * out.ends[end, 2], end
            end += 1
        for q in range(p, end):
            first[q], last[q], covered[q, 0], covered[q, 1] = lowest, highest, low, high
        p = end


# --- integrals by ends ------------------------------------------------------------------------------------------------


@point
def traces(nodes, half, xi):
    """Return shape functions of an edge with two or three nodes at xi of its segment `half`; 0 for a third of two."""
    if nodes == 2:
        return 1.0 - xi, xi, 0.0 * xi
    s = xi + (half - 1.0)
    return 0.5 * s * (s - 1.0), 0.5 * s * (s + 1.0), 1.0 - s * s


@point
def quantities(out, p, covered):
    """Return the six quantities by which integrals are differentiated."""
    ends = out.ends
    return (
        seed(ends[p, 0], LOW, 8), seed(ends[p, 2], HIGH, 8), seed(ends[p, 1], ETA_LOW, 8),
        seed(ends[p, 3], ETA_HIGH, 8), seed(covered[0], COVERED_LOW, 8), seed(covered[1], COVERED_HIGH, 8),
    )  # fmt: skip


@section
def put_change(change, i, k, found, length):
    """Write derivatives by the six quantities, and by the logarithm of the length, into change (7, ., 2)."""
    changes = derivatives(found, 6)
    for q in range(6):
        change[q, i, k] = length * changes[q]
    change[6, i, k] = length * value(found)


@section
def change_of_piece(view, out, p, place, length, covered, fields, dD, dM, dT):
    """Compute derivatives of D, M and T of piece p by six quantities, and by the logarithm of its length."""
    low, high, eta_low, eta_high, covered_low, covered_high = quantities(out, p, covered[p])
    slope = (eta_high - eta_low) / (high - low)
    half, far = view.slave.segment_edge[out.segment[p, 0], 1], view.master.segment_edge[out.segment[p, 1], 1]
    zero = 0.0 * low
    d00, d01, d10, d11, d20, d21 = zero, zero, zero, zero, zero, zero
    m00, m01, m10, m11, m20, m21 = zero, zero, zero, zero, zero, zero
    t00, t01, t10, t11 = zero, zero, zero, zero
    for part in range(PARTS):
        begin, end = cut(low, high, part, place[0], place[1])
        if end > begin:
            for g in range(len(QUADRATIC_POINTS)):
                xi = begin + QUADRATIC_POINTS[g] * (end - begin)
                eta, u = eta_low + (xi - low) * slope, place[0] + place[1] * xi
                first, second = BASIS(u, covered_low, covered_high, fields)
                weight = QUADRATIC_WEIGHTS[g] * (end - begin)
                first, second = weight * first, weight * second
                a, b, c = traces(out.D.shape[1], half, xi)
                d00, d01, d10, d11 = d00 + a * first, d01 + a * second, d10 + b * first, d11 + b * second
                d20, d21 = d20 + c * first, d21 + c * second
                a, b, c = traces(out.M.shape[1], far, eta)
                m00, m01, m10, m11 = m00 + a * first, m01 + a * second, m10 + b * first, m11 + b * second
                m20, m21 = m20 + c * first, m21 + c * second
                t00, t01 = t00 + (1.0 - u) * first, t01 + (1.0 - u) * second
                t10, t11 = t10 + u * first, t11 + u * second
    put_change(dD, 0, 0, d00, length)
    put_change(dD, 0, 1, d01, length)
    put_change(dD, 1, 0, d10, length)
    put_change(dD, 1, 1, d11, length)
    put_change(dM, 0, 0, m00, length)
    put_change(dM, 0, 1, m01, length)
    put_change(dM, 1, 0, m10, length)
    put_change(dM, 1, 1, m11, length)
    put_change(dT, 0, 0, t00, length)
    put_change(dT, 0, 1, t01, length)
    put_change(dT, 1, 0, t10, length)
    put_change(dT, 1, 1, t11, length)
    if out.D.shape[1] == 3:
        put_change(dD, 2, 0, d20, length)
        put_change(dD, 2, 1, d21, length)
    if out.M.shape[1] == 3:
        put_change(dM, 2, 0, m20, length)
        put_change(dM, 2, 1, m21, length)


# --- both together ----------------------------------------------------------------------------------------------------


class Found(NamedTuple):
    """Data for the derivatives of `count` pieces.

    nodes    (p, 6) of each piece
    rates    (p, 5, 12) rows LOW to LENGTH by the coordinates of its nodes
    lengths  (p,) [mm] of its slave segment, weighted
    first, last, covered  (p,), (p,), (p, 2) pieces at the ends of the total overlap of its span, and these ends
    """

    nodes: Any
    rates: Any
    lengths: Any
    first: Any
    last: Any
    covered: Any


@section
def find(both, count, vertices):
    """Return the data for the derivatives of the first `count` pieces."""
    found = Found(
        np.empty((count, 6), np.int64), np.empty((count, 5, 12)), np.empty(count), np.empty(count, np.int64),
        np.empty(count, np.int64), np.zeros((count, 2)),
    )  # fmt: skip
    find_rates(both.sides, both.out, count, PARAMETERS(both.numbers), found.nodes, found.rates, found.lengths)
    if COVERED:
        find_covered(both.sides, both.out, count, vertices, found.first, found.last, found.covered)
    return found


@section
def collect(found, p, shares, nodes, factors):
    """Collect nodes of piece p, and derivatives of seven numbers by their coordinates. Return their number.

    shares  of the spans of multipliers that belong to the slave segments at the ends of the total overlap
    """
    count = 0
    for v in range(6):
        if found.nodes[p, v] >= 0:
            nodes[count] = found.nodes[p, v]
            for c in range(2):
                for q in range(NUMBERS):
                    factors[count, c, q] = found.rates[p, q, 2 * v + c] if q < 4 else 0.0
                factors[count, c, 6] = found.rates[p, LENGTH, 2 * v + c]
            count += 1
    if COVERED:
        for end in range(2):
            other = found.first[p] if end == 0 else found.last[p]
            for v in range(6):
                if found.nodes[other, v] >= 0:
                    z = 0
                    while z < count and nodes[z] != found.nodes[other, v]:
                        z += 1
                    if z == count:
                        nodes[z], factors[z], count = found.nodes[other, v], 0.0, count + 1
                    for c in range(2):
                        factors[z, c, COVERED_LOW + end] += shares[end] * found.rates[other, LOW + end, 2 * v + c]
    return count


@point
def shares_of(both, found, p, whole):
    """Return the `shares` of `collect`."""
    surface, segment = both.sides.slave, both.out.segment
    if COVERED:
        first = place_in_span(surface, segment[found.first[p], 0], whole)[1]
        return first, place_in_span(surface, segment[found.last[p], 0], whole)[1]
    return 1.0, 1.0


@section
def put_sum(change, factors, to):
    """Write the sum over the changes of seven numbers, into (., 2)."""
    for i in range(to.shape[0]):
        for k in range(2):
            total = 0.0
            for q in range(NUMBERS):
                total += factors[q] * change[q, i, k]
            to[i, k] = total


@kernel
def piece_derivatives(bound, count, vertices):
    """Write derivatives of the first `count` pieces and of the normals. Return the numbers of entries of both."""
    table, e = unpack(bound, Derived), 0
    both, to = table.both, table.changes
    view, out, whole = both.sides, both.out, spans_edge(both.sides.slave, vertices)
    found = find(both, count, vertices)
    nodes, factors = np.empty(MOST_NODES, np.int64), np.empty((MOST_NODES, 2, NUMBERS))
    dD, dM = np.zeros((NUMBERS, to.dD.shape[1], 2)), np.zeros((NUMBERS, to.dM.shape[1], 2))
    dT, piece = np.zeros((NUMBERS, 2, 2)), np.empty(2 * MOST_NODES * count, np.int32)
    for p in range(count):
        place = place_in_span(view.slave, out.segment[p, 0], whole)
        change_of_piece(
            view, out, p, place, found.lengths[p], found.covered, PARAMETERS(both.numbers), dD, dM, dT
        )  # fmt: skip
        for z in range(collect(found, p, shares_of(both, found, p, whole), nodes, factors)):
            for c in range(2):
                put_nodes(view, out.segment[p, 0], out.segment[p, 1], e, vertices, to.slave, to.multiplier, to.master)
                to.moved[e], piece[e] = 2 * nodes[z] + c, p
                put_sum(dD, factors[z, c], to.dD[e])
                put_sum(dM, factors[z, c], to.dM[e])
                put_sum(dT, factors[z, c], to.dT[e])
                e += 1
    averaged = np.empty_like(out.normal)
    inward_normals(view.at.slave, view.slave.segments, averaged)
    return e, normal_derivatives(view, out, count, to, piece[:e], averaged)


@point
def weighted(values, at, nodes, p, d):
    """Return the sum of traces times a coordinate of the nodes of entry p."""
    total = values[0] * at[nodes[p, 0], d] + values[1] * at[nodes[p, 1], d]
    if nodes.shape[1] == 3:
        total = total + values[2] * at[nodes[p, 2], d]
    return total


@point
def separated(table, k, d):
    """Return component d of the separation of the owner of multiplier k; 0 if it was dropped."""
    return table.separation[table.owner[k], d] if table.owner[k] >= 0 else 0.0


@section
def change_of_separation(table, p, place, length, covered, fields, change):
    """Compute derivatives of weighted separations (2, 2) of piece p: integrals of psi_j (x - y - r), x, y, r fixed."""
    view, out = table.both.sides, table.both.out
    low, high, eta_low, eta_high, covered_low, covered_high = quantities(out, p, covered[p])
    slope = (eta_high - eta_low) / (high - low)
    half, far = view.slave.segment_edge[out.segment[p, 0], 1], view.master.segment_edge[out.segment[p, 1], 1]
    i, j = out.multiplier[p, 0], out.multiplier[p, 1]
    ax, ay, bx, by = separated(table, i, 0), separated(table, i, 1), separated(table, j, 0), separated(table, j, 1)
    zero = 0.0 * low
    w00, w01, w10, w11 = zero, zero, zero, zero
    for part in range(PARTS):
        begin, end = cut(low, high, part, place[0], place[1])
        if end > begin:
            for g in range(len(QUADRATIC_POINTS)):
                xi = begin + QUADRATIC_POINTS[g] * (end - begin)
                eta, u = eta_low + (xi - low) * slope, place[0] + place[1] * xi
                first, second = BASIS(u, covered_low, covered_high, fields)
                weight = QUADRATIC_WEIGHTS[g] * (end - begin)
                own, other = traces(out.D.shape[1], half, xi), traces(out.M.shape[1], far, eta)
                x = weighted(own, view.at.slave, out.slave, p, 0) - weighted(other, view.at.master, out.master, p, 0)
                y = weighted(own, view.at.slave, out.slave, p, 1) - weighted(other, view.at.master, out.master, p, 1)
                x, y = weight * (x - (1.0 - u) * ax - u * bx), weight * (y - (1.0 - u) * ay - u * by)
                w00, w01, w10, w11 = w00 + first * x, w01 + first * y, w10 + second * x, w11 + second * y
    put_change(change, 0, 0, w00, length)
    put_change(change, 0, 1, w01, length)
    put_change(change, 1, 0, w10, length)
    put_change(change, 1, 1, w11, length)


@kernel
def separation_gradients(bound, count, vertices):
    """Write gradients of the weighted separations of the first `count` pieces. Return the number of normal entries."""
    table = unpack(bound, Separated)
    both, to = table.both, table.gradients
    view, out, whole = both.sides, both.out, spans_edge(both.sides.slave, vertices)
    found = find(both, count, vertices)
    nodes, factors = np.empty(MOST_NODES, np.int64), np.empty((MOST_NODES, 2, NUMBERS))
    change, moved = np.zeros((NUMBERS, 2, 2)), np.zeros((2, 2))
    for p in range(count):
        place = place_in_span(view.slave, out.segment[p, 0], whole)
        change_of_separation(table, p, place, found.lengths[p], found.covered, PARAMETERS(both.numbers), change)
        to.multiplier[p, 0], to.multiplier[p, 1], to.node[p] = out.multiplier[p, 0], out.multiplier[p, 1], -1
        for z in range(collect(found, p, shares_of(both, found, p, whole), nodes, factors)):
            to.node[p, z] = nodes[z]
            for c in range(2):
                put_sum(change, factors[z, c], moved)
                for j in range(2):
                    for d in range(2):
                        to.value[p, j, d, z, c] = moved[j, d]
    return average_derivatives(view, to)
