"""How the separations of the multipliers change with their weights: `segments` and `integrals` in reverse.

The weighted separation of multiplier j is the integral of psi_j rho over its overlaps, rho being the separation of
two points that see each other, less what the separations at the nodes interpolate. At fixed xi only the master's point
moves: eta is linear between the ends of an overlap, and so is its change. So a piece depends on its six nodes by three
numbers alone: how far either end is off, (y - x) x n, and the length of its slave segment.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.compiled.bound_arrays import Floats2, Ints1, Ints2
from contactlab.api.compiled.chains import nodal_normals, segment_normals
from contactlab.api.compiled.contact_tables import GradientsTable, SurfaceTable
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.derivatives import _edge_sum, _normal_derivatives, trace_derivative
from contactlab_mortar.integrals import _POINTS, _WEIGHTS, constant_basis, hat, trace
from contactlab_mortar.segments import carriers, overlap


class GradientTable(NamedTuple):
    """All that gradients are made from and written to; start and candidates are the near list."""

    slave: SurfaceTable
    master: SurfaceTable
    slave_at: Floats2
    master_at: Floats2
    start: Ints1
    candidates: Ints1
    multiplier: Ints2
    master_nodes: Ints2
    normal: Floats2
    owner: Ints1
    separation: Floats2
    out: GradientsTable


@section
def _end(xi, eta, a, e, n, m, c, f, first, last, functional):
    """d[(y - x) x n] at fixed xi and eta by the six nodes (6, 2), those of the normals included.

    first, last = sums of the edges that meet at either end of the slave segment
    """
    qx, qy = n[0] + xi * m[0], n[1] + xi * m[1]
    rx, ry = c[0] + eta * f[0] - a[0] - xi * e[0], c[1] + eta * f[1] - a[1] - xi * e[1]
    for v in range(6):
        weight = 0.0
        if v == 1:
            weight = xi - 1.0
        elif v == 2:
            weight = -xi
        elif v == 4:
            weight = 1.0 - eta
        elif v == 5:
            weight = eta
        functional[v, 0], functional[v, 1] = weight * qy, -weight * qx
    # a normal turns by t x d(edge)/|edge|, t the unit vector of the edges that meet there
    for side in range(2):
        edge, share = (first, 1.0 - xi) if side == 0 else (last, xi)
        size = edge[0] * edge[0] + edge[1] * edge[1]
        turn = share * (rx * edge[1] - ry * edge[0]) / (size * np.sqrt(size))
        x, y = -turn * edge[1], turn * edge[0]
        low, high = (0, 2) if side == 0 else (1, 3)
        functional[low, 0] -= x
        functional[low, 1] -= y
        functional[high, 0] += x
        functional[high, 1] += y


@section
def _own_nodes(functional, before, after):
    """What belongs to a neighbour that is not there belongs to the end of the chain itself."""
    for c in range(2):
        if before < 0:
            functional[1, c] += functional[0, c]
            functional[0, c] = 0.0
        if after < 0:
            functional[2, c] += functional[3, c]
            functional[3, c] = 0.0


@section
def _rho(xi, eta, x, y, r, halves, out):
    """Separation of the traces at xi and eta less the interpolated ones r (2, 2), into out (2,).

    halves = those of quadratic edges that the segments of slave and master are, and `halves` of `hat`
    """
    slave_half, master_half, whole = halves
    for d in range(2):
        total = -hat(whole, xi, 0) * r[0, d] - hat(whole, xi, 1) * r[1, d]
        for i in range(x.shape[0]):
            total += trace(x.shape[0], slave_half, xi, i) * x[i, d]
        for i in range(y.shape[0]):
            total -= trace(y.shape[0], master_half, eta, i) * y[i, d]
        out[d] = total


@section
def _weighted(found, x, y, r, halves, linear, out, rho):
    """Integrals over xi into out (3, 2, 2): psi_j rho, and psi_j dy/d(eta) times either linear weight of its ends."""
    points = max(x.shape[0], y.shape[0]) - (0 if linear else 1)
    start = points * (points - 1) // 2
    for z in range(3):
        for j in range(2):
            out[z, j, 0], out[z, j, 1] = 0.0, 0.0
    width, master_half = found[1] - found[0], halves[1]
    broken = not linear and halves[2] == 0
    for part in range(2 if broken else 1):
        begin, end = found[0], found[1]
        if broken and part == 0:
            end = min(end, 0.5)
        if broken and part == 1:
            begin = max(begin, 0.5)
        if end <= begin:
            continue
        for g in range(start, start + points):
            xi = begin + _POINTS[g] * (end - begin)
            share = (xi - found[0]) / width
            eta = found[2] + share * (found[3] - found[2])
            weight = _WEIGHTS[g] * (end - begin)
            _rho(xi, eta, x, y, r, halves, rho)
            for j in range(2):
                middle = 0.5 * (begin + end)
                psi = hat(halves[2], xi, j) if linear else constant_basis(halves[2], middle, j)
                psi *= weight
                if psi == 0.0:
                    continue
                for d in range(2):
                    along = 0.0
                    for i in range(y.shape[0]):
                        along += trace_derivative(y.shape[0], master_half, eta, i) * y[i, d]
                    out[0, j, d] += psi * rho[d]
                    out[1, j, d] += psi * (1.0 - share) * along
                    out[2, j, d] += psi * share * along


@section
def _basis(linear, whole, xi, end, k):
    """Basis k where an overlap begins (end 0) or ends (1) at xi: on the side of a break that it lies on."""
    if linear:
        return hat(whole, xi, k)
    if whole == 0 and xi == 0.5 and end == 1:
        return 1.0 if k == 0 else 0.0
    return constant_basis(whole, xi, k)


@section
def _averaged(slave_at, segments, node_segments, given, outward, length):
    """Averaged outward normals (m, 2) and lengths of segments; whether the `given` inward ones are those."""
    flat = np.empty((segments.shape[0], 2))
    segment_normals(slave_at, segments, flat, length)
    nodal_normals(node_segments, flat, length, outward)
    for k in range(given.shape[0]):
        if given[k, 0] != -outward[k, 0] or given[k, 1] != -outward[k, 1]:
            return False
    return True


@section
def _stretch(out, e, size, value):
    """What a longer slave segment does: all integrals grow with it."""
    for k in range(2):
        for d in range(2):
            for v in range(6):
                for c in range(2):
                    share = -e[c] if v == 1 else (e[c] if v == 2 else 0.0)
                    value[k, d, v, c] = out[0, k, d] * share / size


@section
def _move_end(end, found, a, e, n, m, c, f, edges_at, alone, functional):
    """Fill what an end of the overlap depends on; returns what it moves of the master's point, and of the limit."""
    xi, eta = found[end], found[2 + end]
    _end(xi, eta, a, e, n, m, c, f, edges_at[0], edges_at[1], functional)
    _own_nodes(functional, alone[0], alone[1])
    qx, qy = n[0] + xi * m[0], n[1] + xi * m[1]
    if xi == float(end):
        return -1.0 / (f[0] * qy - f[1] * qx), 0.0
    rx, ry = c[0] + eta * f[0] - a[0] - xi * e[0], c[1] + eta * f[1] - a[1] - xi * e[1]
    limit = -1.0 / (-e[0] * qy + e[1] * qx + rx * m[1] - ry * m[0])
    return -limit * (found[3] - found[2]) / (found[1] - found[0]), limit


@kernel
def mortar_gradients(bound, count, linear, vertices):
    """Fill the gradients of the first `count` pieces and of the averaged normals; returns the number of the latter.

    `bound` is the address of a `GradientTable`. -1 where the normals are not the averaged ones.
    """
    table = unpack(bound, GradientTable)
    segments, node_segments, edges, segment_edge = table.slave
    master_segments, _, master_edges, master_segment_edge = table.master
    slave_at, master_at, start, candidates = table.slave_at, table.master_at, table.start, table.candidates
    p_multiplier, p_master, p_normal = table.multiplier, table.master_nodes, table.normal
    owner, separation = table.owner, table.separation
    multiplier, node, value, normal_of, normal_moved, dnormal = table.out
    outward, length = np.empty((slave_at.shape[0], 2)), np.empty(segments.shape[0])
    if not _averaged(slave_at, segments, node_segments, p_normal, outward, length):
        return -1
    found, out, rho, functional = np.empty(6), np.empty((3, 2, 2)), np.empty(2), np.empty((6, 2))
    e, f, m, edges_at = np.empty(2), np.empty(2), np.empty(2), np.empty((2, 2))
    x, y, r = np.empty((edges.shape[1], 2)), np.empty((master_edges.shape[1], 2)), np.empty((2, 2))
    vertices = vertices and edges.shape[1] == 3
    p, shift = 0, slave_at.shape[0]
    for s in range(segments.shape[0]):
        i, j = segments[s, 0], segments[s, 1]
        first, second = carriers(s, edges, segment_edge) if vertices else (i, j)
        if p >= count or p_multiplier[p, 0] != first or p_multiplier[p, 1] != second:
            continue
        a, b, n = slave_at[i], slave_at[j], outward[i]
        for d in range(2):
            e[d], m[d] = b[d] - a[d], outward[j, d] - n[d]
            r[0, d] = separation[owner[first], d] if owner[first] >= 0 else 0.0
            r[1, d] = separation[owner[second], d] if owner[second] >= 0 else 0.0
            for t in range(edges.shape[1]):
                x[t, d] = slave_at[edges[segment_edge[s, 0], t], d]
        before, after = node_segments[i, 0], node_segments[j, 1]
        _edge_sum(i, slave_at, segments, node_segments, edges_at[0])
        _edge_sum(j, slave_at, segments, node_segments, edges_at[1])
        for z in range(start[s], start[s + 1]):
            if p >= count or p_multiplier[p, 0] != first or p_multiplier[p, 1] != second:
                break
            seg = candidates[z]
            own = master_edges[master_segment_edge[seg, 0]]
            if own[0] != p_master[p, 0] or own[1] != p_master[p, 1]:
                continue
            c, close = master_at[master_segments[seg, 0]], master_at[master_segments[seg, 1]]
            if not overlap(a, b, n, outward[j], c, close, found):
                continue
            for d in range(2):
                f[d] = close[d] - c[d]
                for t in range(master_edges.shape[1]):
                    y[t, d] = master_at[own[t], d]
            whole = segment_edge[s, 1] + 1 if vertices else 0
            halves = (segment_edge[s, 1], master_segment_edge[seg, 1], whole)
            _weighted(found, x, y, r, halves, linear, out, rho)
            multiplier[p, 0], multiplier[p, 1] = first, second
            node[p, 0] = segments[before, 0] if before >= 0 else -1
            node[p, 1], node[p, 2] = i, j
            node[p, 3] = segments[after, 1] if after >= 0 else -1
            node[p, 4], node[p, 5] = shift + master_segments[seg, 0], shift + master_segments[seg, 1]
            _stretch(out, e, length[s], value[p])
            for end in range(2):
                off, limit = _move_end(end, found, a, e, n, m, c, f, edges_at, (before, after), functional)
                _rho(found[end], found[2 + end], x, y, r, halves, rho)
                for k in range(2):
                    psi = _basis(linear, whole, found[end], end, k) * (limit if end == 1 else -limit)
                    for d in range(2):
                        amount = length[s] * (psi * rho[d] - off * out[1 + end, k, d])
                        for v in range(6):
                            value[p, k, d, v, 0] += amount * functional[v, 0]
                            value[p, k, d, v, 1] += amount * functional[v, 1]
            p += 1
    return _normal_derivatives(slave_at, segments, node_segments, normal_of, normal_moved, dnormal)
