"""Derivatives of the pieces by the positions of their nodes: what `segments` and `integrals` do, differentiated.

A piece depends on six nodes: the ends of its slave segment and their neighbours, by the averaged normals,
and the ends of its master segment. Each of their twelve coordinates is moved in turn.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point, section
from contactlab_mortar.integrals import _POINTS, _WEIGHTS, constant_basis, hat, hat_derivative, trace
from contactlab_mortar.segments import _begin, carriers, overlap


@point
def trace_derivative(nodes, half, xi, i):
    """d(trace)/d(xi)."""
    if nodes == 2:
        return -1.0 if i == 0 else 1.0
    s = xi + half - 1.0
    if i == 0:
        return s - 0.5
    if i == 1:
        return s + 0.5
    return -2.0 * s


@kernel
def _edge_sum(node, positions, segments, node_segments, out):
    """Sum (2,) of the edge vectors that meet at a slave node; the normal is this turned by -90 degrees."""
    before, after = node_segments[node, 0], node_segments[node, 1]
    first = segments[before, 0] if before >= 0 else node
    last = segments[after, 1] if after >= 0 else node
    out[0] = positions[last, 0] - positions[first, 0]
    out[1] = positions[last, 1] - positions[first, 1]


@kernel
def _turned_unit(edge, change, out):
    """Derivative (2,) of the unit vector (edge_y, -edge_x)/|edge| when the edge vector changes."""
    size = np.sqrt(edge[0] * edge[0] + edge[1] * edge[1])
    nx, ny = edge[1] / size, -edge[0] / size
    x, y = change[1] / size, -change[0] / size
    along = x * nx + y * ny
    out[0], out[1] = x - along * nx, y - along * ny


@kernel
def _limit_derivatives(xi, eta, fixed, a, e, n, m, c, f, da, de, dn, dm, dc, df, out):
    """Derivatives (2,) of xi and eta at one end of an overlap.

    fixed  the end is one of the slave segment, xi does not change; otherwise eta is an end of the master
    """
    qx, qy = n[0] + xi * m[0], n[1] + xi * m[1]
    rx, ry = c[0] + eta * f[0] - a[0] - xi * e[0], c[1] + eta * f[1] - a[1] - xi * e[1]
    # what (y - x) x n changes by at fixed xi and eta
    dqx, dqy = dn[0] + xi * dm[0], dn[1] + xi * dm[1]
    drx, dry = dc[0] + eta * df[0] - da[0] - xi * de[0], dc[1] + eta * df[1] - da[1] - xi * de[1]
    change = drx * qy - dry * qx + rx * dqy - ry * dqx
    out[0], out[1] = 0.0, 0.0
    if fixed:
        out[1] = -change / (f[0] * qy - f[1] * qx)
    else:
        out[0] = -change / (-e[0] * qy + e[1] * qx + rx * m[1] - ry * m[0])


@section
def integrate_derivatives(found, low, high, length, dlength, slave_half, master_half, halves, linear, at, dD, dM, dT):
    """Add the derivatives of an overlap's integrals to entry `at`; low, high = derivatives of (xi, eta) at its ends."""
    slave_nodes, master_nodes = dD.shape[1], dM.shape[1]
    points = max(slave_nodes, master_nodes) - (0 if linear else 1)
    start = points * (points - 1) // 2
    slope = (found[3] - found[2]) / (found[1] - found[0])
    dslope = (high[1] - low[1] - slope * (high[0] - low[0])) / (found[1] - found[0])
    whole = linear or halves != 0
    for part in range(1 if whole else 2):
        begin, end, dbegin, dend = found[0], found[1], low[0], high[0]
        if not whole and part == 0 and end > 0.5:
            end, dend = 0.5, 0.0
        if not whole and part == 1 and begin < 0.5:
            begin, dbegin = 0.5, 0.0
        if end <= begin:
            continue
        for g in range(start, start + points):
            t = _POINTS[g]
            xi, dxi = begin + t * (end - begin), dbegin + t * (dend - dbegin)
            eta = found[2] + (xi - found[0]) * slope
            deta = low[1] + (dxi - low[0]) * slope + (xi - found[0]) * dslope
            weight = _WEIGHTS[g] * (end - begin) * length
            dweight = _WEIGHTS[g] * ((dend - dbegin) * length + (end - begin) * dlength)
            for k in range(2):
                if linear:
                    basis, dbasis = hat(halves, xi, k), hat_derivative(halves, k) * dxi
                else:
                    # the middle of a part tells on which side of the break it lies
                    basis, dbasis = constant_basis(halves, 0.5 * (begin + end), k), 0.0
                psi, dpsi = weight * basis, dweight * basis + weight * dbasis
                for i in range(slave_nodes):
                    dD[at, i, k] += dpsi * trace(slave_nodes, slave_half, xi, i)
                    dD[at, i, k] += psi * trace_derivative(slave_nodes, slave_half, xi, i) * dxi
                for i in range(master_nodes):
                    dM[at, i, k] += dpsi * trace(master_nodes, master_half, eta, i)
                    dM[at, i, k] += psi * trace_derivative(master_nodes, master_half, eta, i) * deta
                for i in range(2):
                    dT[at, i, k] += dpsi * hat(halves, xi, i) + psi * hat_derivative(halves, i) * dxi


@kernel
def mortar_derivatives(slave, master, slave_at, master_at, near, linear, vertices, pieces, out):
    """Derivatives of all pieces and normals; returns the numbers of entries of both.

    slave, master, near as in `mortar_pieces`; pieces = (count, multipliers, master nodes, inward normals)
    out = (slave, multiplier, master, moved, dD, dM, dT, normal_of, normal_moved, dnormal)
    """
    segments, node_segments, edges, segment_edge = slave
    master_segments, master_edges, master_segment_edge = master
    start, candidates = near
    total, multipliers, master_nodes, inward = pieces
    o_slave, o_multiplier, o_master, o_moved, dD, dM, dT, normal_of, normal_moved, dnormal = out
    found, nodes = np.empty(6), np.empty(6, np.int64)
    moves = np.zeros((6, 2))
    edge_i, edge_j, change = np.empty(2), np.empty(2), np.empty(2)
    dn, dn_end, dm, de, df = np.empty(2), np.empty(2), np.empty(2), np.empty(2), np.empty(2)
    n_end = np.empty(2)
    e, f, n, m, low, high = np.empty(2), np.empty(2), np.empty(2), np.empty(2), np.empty(2), np.empty(2)
    shift, p, at = slave_at.shape[0], 0, 0
    vertices = vertices and edges.shape[1] == 3
    for s in range(segments.shape[0]):
        i, j = segments[s, 0], segments[s, 1]
        first_carrier, second_carrier = carriers(s, edges, segment_edge) if vertices else (i, j)
        a, b = slave_at[i], slave_at[j]
        e[0], e[1] = b[0] - a[0], b[1] - a[1]
        length = np.sqrt(e[0] * e[0] + e[1] * e[1])
        n[0], n[1] = -inward[i, 0], -inward[i, 1]
        n_end[0], n_end[1] = -inward[j, 0], -inward[j, 1]
        m[0], m[1] = n_end[0] - n[0], n_end[1] - n[1]
        before, after = node_segments[i, 0], node_segments[j, 1]
        nodes[0] = segments[before, 0] if before >= 0 else -1
        nodes[1], nodes[2] = i, j
        nodes[3] = segments[after, 1] if after >= 0 else -1
        _edge_sum(i, slave_at, segments, node_segments, edge_i)
        _edge_sum(j, slave_at, segments, node_segments, edge_j)
        for z in range(start[s], start[s + 1]):
            if p >= total or multipliers[p, 0] != first_carrier or multipliers[p, 1] != second_carrier:
                break
            seg = candidates[z]
            own = master_edges[master_segment_edge[seg, 0]]
            if own[0] != master_nodes[p, 0] or own[1] != master_nodes[p, 1]:
                continue
            nodes[4], nodes[5] = shift + master_segments[seg, 0], shift + master_segments[seg, 1]
            c, d = master_at[master_segments[seg, 0]], master_at[master_segments[seg, 1]]
            if not overlap(a, b, n, n_end, c, d, found):
                continue
            f[0], f[1] = d[0] - c[0], d[1] - c[1]
            for v in range(6):
                if nodes[v] < 0:
                    continue
                for direction in range(2):
                    for x in range(6):
                        moves[x, 0], moves[x, 1] = 0.0, 0.0
                    moves[v, direction] = 1.0
                    # the averaged normals turn with the sums of the edges that meet there
                    for x in range(2):
                        first = moves[0, x] if before >= 0 else moves[1, x]
                        change[x] = moves[2, x] - first
                    _turned_unit(edge_i, change, dn)
                    for x in range(2):
                        last = moves[3, x] if after >= 0 else moves[2, x]
                        change[x] = last - moves[1, x]
                    _turned_unit(edge_j, change, dn_end)
                    for x in range(2):
                        dm[x] = dn_end[x] - dn[x]
                        de[x], df[x] = moves[2, x] - moves[1, x], moves[5, x] - moves[4, x]
                    _limit_derivatives(found[0], found[2], found[0] == 0.0, a, e, n, m, c, f, moves[1], de, dn, dm,
                                moves[4], df, low)  # fmt: skip
                    _limit_derivatives(found[1], found[3], found[1] == 1.0, a, e, n, m, c, f, moves[1], de, dn, dm,
                                moves[4], df, high)  # fmt: skip
                    _begin(edges, segment_edge[s, 0], o_slave, at, dD)
                    _begin(master_edges, master_segment_edge[seg, 0], o_master, at, dM)
                    o_multiplier[at, 0], o_multiplier[at, 1] = first_carrier, second_carrier
                    o_moved[at] = 2 * nodes[v] + direction
                    for k in range(2):
                        dT[at, 0, k], dT[at, 1, k] = 0.0, 0.0
                    dlength = (e[0] * de[0] + e[1] * de[1]) / length
                    integrate_derivatives(found, low, high, length, dlength, segment_edge[s, 1],
                                     master_segment_edge[seg, 1], segment_edge[s, 1] + 1 if vertices else 0, linear,
                                     at, dD, dM, dT)  # fmt: skip
                    at += 1
            p += 1
    return at, _normal_derivatives(slave_at, segments, node_segments, normal_of, normal_moved, dnormal)


@section
def _normal_derivatives(slave_at, segments, node_segments, normal_of, normal_moved, dnormal):
    """Derivatives of the inward normals by the ends of the edges that meet at each node."""
    edge, change, out, at = np.empty(2), np.empty(2), np.empty(2), 0
    for k in range(slave_at.shape[0]):
        before, after = node_segments[k, 0], node_segments[k, 1]
        _edge_sum(k, slave_at, segments, node_segments, edge)
        for end in range(2):
            if end == 0:
                node = segments[before, 0] if before >= 0 else k
            else:
                node = segments[after, 1] if after >= 0 else k
            for direction in range(2):
                change[0], change[1] = 0.0, 0.0
                change[direction] = -1.0 if end == 0 else 1.0
                _turned_unit(edge, change, out)
                normal_of[at], normal_moved[at] = k, 2 * node + direction
                dnormal[at, 0], dnormal[at, 1] = -out[0], -out[1]
                at += 1
    return at
