"""Derivatives of pieces at points, and of their normals, by node positions, with dual numbers.

A piece is its weight times shape functions at the projection. The weight depends on lengths of slave segments, the
projection on the point, its normal and the nodes of the master segment or edge: ten quantities, chained to nodes.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.dual import derivatives, seed, value
from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.segments import MasterSegment, SlavePoint
from contactlab.api.tensors import Vector
from contactlab.formulas.point_kernels import DerivedPoints, Points, TurnedPoints, gauss_point, measure
from contactlab.formulas.point_pieces import ALONE, FOOT, POINTS, in_wedge, parabola, tangent_at
from contactlab.formulas.segment_kernels import PARAMETERS, trace
from contactlab.formulas.segment_normals import edge_between, inward_normals, neighbours, node, normal_derivatives

MOST_NODES = 16  # of a piece: the slave's edges on both sides of a node with their neighbours, and the master's edge
WEIGHT, PLACE = 0, 1
"""Variables of a piece: the logarithm of its weight; eta of its projection, or xi of a corner in its slave segment."""


# --- normals ----------------------------------------------------------------------------------------------------------


@point
def three(one, a, two, b, other, c):
    """Return nodes a, b and c of three arrays of positions as dual numbers by their six coordinates."""
    return (
        Vector(seed(one[a, 0], 0, 8), seed(one[a, 1], 1, 8)),
        Vector(seed(two[b, 0], 2, 8), seed(two[b, 1], 3, 8)),
        Vector(seed(other[c, 0], 4, 8), seed(other[c, 1], 5, 8)),
    )


@section
def direction(t, p, nodes):
    """Return the normal of piece p of a node, by coordinates of up to three `nodes` (3,), filled in, -1 for none."""
    view, out = t.sides, t.out
    x, y, shift = view.at.slave, view.at.master, view.at.slave.shape[0]
    q, holder = out.segment[p, 0], out.segment[p, 1]
    if q < 0:  # a corner: opposite to the normal of the slave's segment
        i, j = view.slave.segments[-1 - q, 0], view.slave.segments[-1 - q, 1]
        nodes[0], nodes[1], nodes[2] = i, j, -1
        a, b, _ = three(x, i, x, j, x, i)
        return (a - b).turned().unit()
    if holder < 0:
        v = -1 - holder
        before, after = view.master.node_segments[v, 0], view.master.node_segments[v, 1]
        one, other = node(t.master_normal, before), node(t.master_normal, after)
        if in_wedge(node(x, q), node(y, v), one, other, t.master_length[after]):
            nodes[0], nodes[1], nodes[2] = q, shift + v, -1
            a, b, _ = three(x, q, y, v, y, v)
            return (a - b).unit()
        i, j = view.master.segments[before, 0], view.master.segments[after, 1]
        nodes[0], nodes[1], nodes[2] = shift + i, shift + v, shift + j
        a, b, c = three(y, i, y, v, y, j)
        return ((b - a).turned().unit() + (c - b).turned().unit()).unit()
    i, j, k = out.master[p, 0], out.master[p, 1], out.master[p, out.master.shape[1] - 1]
    a, b, c = three(y, i, y, j, y, k)
    nodes[0], nodes[1], nodes[2] = shift + i, shift + j, -1
    if out.ends[p, 2] != 0.0:
        nodes[2] = shift + k
        return parabola(a, b, c, out.ends[p, 1])[1].turned().unit()
    return (b - a).turned().unit()


@kernel
def normals(bound, count, normal):
    """Fill normals (multipliers, 2) of the first `count` pieces of nodes at the surfaces of a `Points`."""
    t, nodes = unpack(bound, Points), np.empty(3, np.int64)
    measure(t)
    for p in range(count):
        found, k = direction(t, p, nodes), t.out.multiplier[p, 0]
        normal[k, 0], normal[k, 1] = value(found.x), value(found.y)


@section
def put_turns(t, p, nodes, to, e):
    """Write derivatives of the normal of piece p from entry e on. Return the next."""
    found = direction(t, p, nodes)
    x, y = derivatives(found.x, 6), derivatives(found.y, 6)
    for q in range(6):
        if nodes[q // 2] >= 0:
            to.normal_of[e], to.normal_moved[e] = t.out.multiplier[p, 0], 2 * nodes[q // 2] + q % 2
            to.dnormal[e, 0], to.dnormal[e, 1] = x[q], y[q]
            e += 1
    return e


@section
def put_own_turns(t, p, to, e):
    """Write derivatives of the normal of the slave's segment at Gauss piece p from entry e on. Return the next."""
    x, s = t.sides.at.slave, t.out.segment[p, 0] // max(POINTS, 1)
    i, j = t.sides.slave.segments[s, 0], t.sides.slave.segments[s, 1]
    a, b, _ = three(x, i, x, j, x, i)
    found = (a - b).turned().unit()
    x, y = derivatives(found.x, 6), derivatives(found.y, 6)
    for q in range(4):
        to.normal_of[e], to.normal_moved[e] = t.out.multiplier[p, 0], 2 * (i if q < 2 else j) + q % 2
        to.dnormal[e, 0], to.dnormal[e, 1] = x[q], y[q]
        e += 1
    return e


@kernel
def turns(bound, count):
    """Write derivatives of normals of the first `count` pieces of nodes, at fixed projections. Return their number."""
    table, nodes, e = unpack(bound, TurnedPoints), np.empty(3, np.int64), 0
    measure(table.points)
    for p in range(count):
        e = put_turns(table.points, p, nodes, table.gradients, e)
    return e


# --- dependence of a piece on nodes -----------------------------------------------------------------------------------


@section
def place_of(nodes, node):
    """Return the index of a node among the nodes[0] found nodes; append it if missing."""
    z = 1
    while z <= nodes[0] and nodes[z] != node:
        z += 1
    if z > nodes[0]:
        nodes[0], nodes[z] = z, node
    return z


@section
def add_length(t, s, share, nodes, factors):
    """Add the derivative of the logarithm of the weight by `share` [1/mm] of the length of slave segment s."""
    i, j = t.sides.slave.segments[s, 0], t.sides.slave.segments[s, 1]
    along = node(t.sides.at.slave, j) - node(t.sides.at.slave, i)
    along = (share / t.slave_length[s]) * along
    for end in range(2):
        z, sign = place_of(nodes, j if end else i), 1.0 if end else -1.0
        factors[z, 0, WEIGHT] += sign * along.x
        factors[z, 1, WEIGHT] += sign * along.y


@section
def add_weight(t, q, nodes, factors):
    """Add the derivative of the length of a point: node q, or Gauss point q."""
    surface = t.sides.slave
    for side in range(2):
        s, share, halves = surface.node_segments[q, side] if POINTS == 0 else q // max(POINTS, 1), 0.5, 1
        if s < 0 or (POINTS > 0 and side == 1):
            continue
        length = t.tributary[q] if POINTS == 0 else t.slave_length[s]
        middle = surface.edges[surface.segment_edge[s, 0], surface.edges.shape[1] - 1]
        if POINTS > 0:
            share = 1.0
        elif surface.edges.shape[1] == 3:
            share, halves = (4.0 / 6.0, 1) if middle == q else (1.0 / 6.0, 2)
        for half in range(halves):
            of = s if halves == 1 else surface.node_segments[middle, half]
            add_length(t, of, share / length, nodes, factors)


@section
def add_average(t, i, share, rates, nodes, factors):
    """Add the derivative of the averaged normal of slave node i, a `share` of the point's normal."""
    before, after = neighbours(i, t.sides.slave)
    normal = edge_between(t.sides.at.slave, before, after).turned().unit()
    x, y = derivatives(normal.x, 4), derivatives(normal.y, 4)
    for k in range(4):
        z = place_of(nodes, before if k < 2 else after)
        factors[z, k % 2, PLACE] += share * (rates[2] * x[k] + rates[3] * y[k])


@section
def found_point(t, q, xi):
    """Return point q of the slave."""
    if POINTS == 0:
        return SlavePoint(node(t.sides.at.slave, q), node(t.outward, q))
    return gauss_point(t, q // max(POINTS, 1), xi)


@section
def foot_rates(t, p, rates):
    """Compute the derivative of eta of piece p by ten quantities: the point, its normal, three master nodes."""
    view, out = t.sides, t.out
    q, at, fields = out.segment[p, 0], view.at.master, PARAMETERS(t.numbers)
    x = found_point(t, q, out.ends[p, 0])
    i, j, k = out.master[p, 0], out.master[p, 1], out.master[p, out.master.shape[1] - 1]
    here = SlavePoint(
        Vector(seed(x.at.x, 0, 12), seed(x.at.y, 1, 12)), Vector(seed(x.normal.x, 2, 12), seed(x.normal.y, 3, 12))
    )
    a, b = Vector(seed(at[i, 0], 4, 12), seed(at[i, 1], 5, 12)), Vector(seed(at[j, 0], 6, 12), seed(at[j, 1], 7, 12))
    master, curved = MasterSegment(a, b), out.ends[p, 2] != 0.0
    if curved:
        c = Vector(seed(at[k, 0], 8, 12), seed(at[k, 1], 9, 12))
        master = tangent_at(a, b, c, seed(out.ends[p, 1], 10, 12))
    changes = derivatives(FOOT(here, master, fields), 11)
    slope = -changes[10] if curved else 1.0
    least = -1.0 if curved else 0.0
    inside = out.ends[p, 1] > least and out.ends[p, 1] < 1.0 and slope != 0.0
    for k in range(10):
        rates[k] = changes[k] / slope if inside else 0.0


@section
def add_foot(t, p, rates, nodes, factors):
    """Add the derivative of the projection of piece p."""
    view, out = t.sides, t.out
    foot_rates(t, p, rates)
    q, shift = out.segment[p, 0], view.at.slave.shape[0]
    if POINTS == 0:
        z = place_of(nodes, q)
        factors[z, 0, PLACE] += rates[0]
        factors[z, 1, PLACE] += rates[1]
    else:
        s = q // max(POINTS, 1)
        for k in range(out.slave.shape[1]):
            z, share = (
                place_of(nodes, out.slave[p, k]),
                trace(out.slave.shape[1], view.slave.segment_edge[s, 1], out.ends[p, 0], k),
            )
            factors[z, 0, PLACE] += share * rates[0]
            factors[z, 1, PLACE] += share * rates[1]
    if rates[2] != 0.0 or rates[3] != 0.0:
        if POINTS == 0:
            add_average(t, q, 1.0, rates, nodes, factors)
        else:
            s = q // max(POINTS, 1)
            for k in range(2):
                share = out.ends[p, 0] if k else 1.0 - out.ends[p, 0]
                add_average(t, view.slave.segments[s, k], share, rates, nodes, factors)
    for k in range(3 if out.ends[p, 2] != 0.0 else 2):
        z = place_of(nodes, shift + out.master[p, k])
        factors[z, 0, PLACE] += rates[4 + 2 * k]
        factors[z, 1, PLACE] += rates[5 + 2 * k]


@section
def add_corner(t, p, nodes, factors):
    """Add the derivative of the position of a master corner in the slave segment that it presses on."""
    view, out = t.sides, t.out
    i, j, v = out.slave[p, 0], out.slave[p, 1], out.master[p, 0]
    a, b, c = three(view.at.slave, i, view.at.slave, j, view.at.master, v)
    changes = derivatives(((c - a) @ (b - a)) / ((b - a) @ (b - a)), 6)
    for k in range(6):
        z = place_of(nodes, i if k < 2 else (j if k < 4 else view.at.slave.shape[0] + v))
        factors[z, k % 2, PLACE] += changes[k]


@section
def put_changes(t, p, to, e, c, weight, place):
    """Write entry e: the derivative of piece p by a coordinate, by changes of its weight and its place."""
    out, corner, s = t.out, t.out.segment[p, 0] < 0, t.out.ends[p, 1]
    for i in range(out.slave.shape[1]):
        to.slave[e, i] = out.slave[p, i]
    for i in range(out.master.shape[1]):
        to.master[e, i] = out.master[p, i]
    to.moved[e] = c
    for k in range(out.multiplier.shape[1]):
        to.multiplier[e, k], psi = out.multiplier[p, k], 0.0
        for i in range(out.slave.shape[1]):
            to.dD[e, i, k], psi = weight * out.D[p, i, k], psi + out.D[p, i, k]
        for i in range(out.master.shape[1]):
            to.dM[e, i, k] = weight * out.M[p, i, k]
        for i in range(out.multiplier.shape[1]):
            to.dT[e, i, k] = weight * out.T[p, i, k]
        if corner:
            to.dD[e, 0, k] -= place * psi
            to.dD[e, 1, k] += place * psi
        elif out.ends[p, 2] != 0.0:
            to.dM[e, 0, k] += (s - 0.5) * place * psi
            to.dM[e, 1, k] += (s + 0.5) * place * psi
            to.dM[e, 2, k] -= 2.0 * s * place * psi
        elif out.segment[p, 1] >= 0:
            to.dM[e, 0, k] -= place * psi
            to.dM[e, 1, k] += place * psi


@section
def put_rolls(t, p, nodes, factors, to, e):
    """Write derivatives of a quadratic edge's normal as the projection of piece p moves along it, from entry e on."""
    at, held, s = t.sides.at.master, t.out.master, t.out.ends[p, 1]
    a, b, middle = node(at, held[p, 0]), node(at, held[p, 1]), node(at, held[p, 2])
    found = parabola(a, b, middle, seed(s, 0, 4))[1].turned().unit()
    x, y = derivatives(found.x, 4)[0], derivatives(found.y, 4)[0]
    for z in range(1, nodes[0] + 1):
        for c in range(2):
            if factors[z, c, PLACE] != 0.0:
                to.normal_of[e], to.normal_moved[e] = t.out.multiplier[p, 0], 2 * nodes[z] + c
                to.dnormal[e, 0], to.dnormal[e, 1] = factors[z, c, PLACE] * x, factors[z, c, PLACE] * y
                e += 1
    return e


@kernel
def piece_derivatives(bound, count):
    """Write derivatives of the first `count` pieces and of the normals. Return the numbers of entries of both."""
    table, e, turned = unpack(bound, DerivedPoints), 0, 0
    t, to = table.points, table.changes
    measure(t)
    m, three_nodes, rates = t.outward.shape[0], np.empty(3, np.int64), np.empty(10)
    nodes, factors = np.empty(MOST_NODES + 1, np.int64), np.empty((MOST_NODES + 1, 2, 2))
    piece = np.empty(2 * MOST_NODES * count, np.int32)
    for p in range(count):
        nodes[0] = 0
        factors[:] = 0.0
        q = t.out.segment[p, 0]
        add_weight(t, q if q >= 0 else t.out.multiplier[p, 0] % m, nodes, factors)
        if q < 0:
            add_corner(t, p, nodes, factors)
        elif t.out.segment[p, 1] >= 0:
            add_foot(t, p, rates, nodes, factors)
        for z in range(1, nodes[0] + 1):
            for c in range(2):
                put_changes(t, p, to, e, 2 * nodes[z] + c, factors[z, c, WEIGHT], factors[z, c, PLACE])
                piece[e], e = p, e + 1
        if ALONE:
            turned = put_own_turns(t, p, to, turned)
        if POINTS == 0:
            turned = put_turns(t, p, three_nodes, to, turned)
            if t.out.ends[p, 2] != 0.0:
                turned = put_rolls(t, p, nodes, factors, to, turned)
    if POINTS == 0 or ALONE:
        return e, turned
    averaged = np.empty_like(t.out.normal)
    inward_normals(t.sides.at.slave, t.sides.slave.segments, averaged)
    return e, normal_derivatives(t.sides, t.out, count, to, piece[:e], averaged)
