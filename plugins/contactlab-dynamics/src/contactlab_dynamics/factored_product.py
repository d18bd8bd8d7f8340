"""Products with A = R C R^T, what unit forces of factored conditions do to all gaps, in O(conditions).

R = E + T^-T B, E being the conditions' own slave nodes, is never formed. A product is two substitutions with T, the
matrix B C B^T between them, and two more. Conditions that share a node of B are neighbours, so that B C B^T is a
narrow band: once it is there, a product touches no node at all. If a node counts in E and in B, twice in E, or
joins conditions far apart, forces are spread over the nodes and their motions gathered instead.

`rows` are `FactoredRows` throughout, of which the first k are in use.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.kernel import kernel, section

WIDEST = 24  # conditions to either side; wider bands cost more than going through the nodes


class Touched(NamedTuple):
    """The L nodes that rows touch, numbered among themselves.

    local, row (z,) node and row of each entry; own (k,) the slave node of weight one in each row, -1 for none
    """

    local: Ints
    row: Ints
    own: Ints


class Compliances(NamedTuple):
    """Motions of touched nodes and conditions under a unit force.

    soft (L, 2) [mm/N] nodes, band (1 or 2, diagonals, k) B C B^T, stiff (k,) [mm/N] share of the own nodes,
    scale (k,) [mm/N] estimate for each row as a whole
    """

    soft: Floats
    band: Floats
    stiff: Floats
    scale: Floats


class Scratch(NamedTuple):
    """padded (2, k + diagonals), zero in the first h places and after the conditions' places; carried (2, k);
    nodal (L, 2)."""

    padded: Floats
    carried: Floats
    nodal: Floats


@section
def _solve(rows, y, cx, cy, pad):
    """T^-1 of the forces y times their normals, from position `pad` of cx and cy on.

    In all substitutions what depends on the last place comes first in its sum: one fused multiply-add per place then
    is the whole chain of dependences, about half of what it is the other way round.
    """
    normal, above, below, inverse = rows.normal, rows.above, rows.below, rows.inverse
    px, py = 0.0, 0.0
    for i in range(y.size):
        v = -below[i] * inverse[i - 1] if i > 0 else 0.0
        px, py = v * px + y[i] * normal[i, 0], v * py + y[i] * normal[i, 1]
        cx[pad + i], cy[pad + i] = px, py
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(y.size - 1, -1, -1):
        u, v = inverse[i], -factor * inverse[i]
        px, py = v * px + u * cx[pad + i], v * py + u * cy[pad + i]
        cx[pad + i], cy[pad + i] = px, py
        factor = above[i]


@section
def _finish(rows, wx, wy, out):
    """Gaps (k,): the normal parts of T^-T w, of which the first substitution is done."""
    normal, below, inverse = rows.normal, rows.below, rows.inverse
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(out.size - 1, -1, -1):
        v = -factor * inverse[i]
        px, py = v * px + wx[i], v * py + wy[i]
        out[i] = normal[i, 0] * px + normal[i, 1] * py
        factor = below[i]


@kernel
def spread(rows, touched, y, carried, nodal):
    """Nodal forces R^T y on the touched nodes, (L, 2). `carried` (2, k) is scratch."""
    local, row, own, normal = touched.local, touched.row, touched.own, rows.normal
    for n in range(nodal.shape[0]):
        nodal[n, 0], nodal[n, 1] = 0.0, 0.0
    cx, cy = carried[0], carried[1]
    _solve(rows, y, cx, cy, 0)
    for i in range(y.size):
        n = own[i]
        if n >= 0:
            nodal[n, 0] += y[i] * normal[i, 0]
            nodal[n, 1] += y[i] * normal[i, 1]
    for z in range(local.size):
        n, i = local[z], row[z]
        nodal[n, 0] += rows.weight[z] * cx[i]
        nodal[n, 1] += rows.weight[z] * cy[i]


@kernel
def _through_nodes(rows, touched, soft, y, scratch, out):
    """Product A y (k,), by way of the motions of all touched nodes."""
    nodal, above, inverse = scratch.nodal, rows.above, rows.inverse
    spread(rows, touched, y, scratch.carried, nodal)
    for n in range(nodal.shape[0]):
        nodal[n, 0], nodal[n, 1] = nodal[n, 0] * soft[n, 0], nodal[n, 1] * soft[n, 1]
    wx, wy = scratch.carried[0], scratch.carried[1]
    px, py = 0.0, 0.0
    for i in range(y.size):
        x, y_ = 0.0, 0.0
        for z in range(rows.start[i], rows.start[i + 1]):
            x += rows.weight[z] * nodal[touched.local[z], 0]
            y_ += rows.weight[z] * nodal[touched.local[z], 1]
        u, v = inverse[i], -above[i] * inverse[i]
        px, py = v * px + u * x, v * py + u * y_
        wx[i], wy[i] = px, py
    _finish(rows, wx, wy, out)
    for i in range(y.size):
        n = touched.own[i]
        if n >= 0:
            out[i] += rows.normal[i, 0] * nodal[n, 0] + rows.normal[i, 1] * nodal[n, 1]


@kernel
def _weighed(count, band, moved, out):
    """Rows of a band, stored by diagonals, times `moved` (k + 2 h,), four diagonals at a time."""
    for i in range(count):
        out[i] = 0.0
    for d in range(0, band.shape[0], 4):
        a, b, c, e = band[d], band[d + 1], band[d + 2], band[d + 3]
        p, q, r, s = moved[d:], moved[d + 1 :], moved[d + 2 :], moved[d + 3 :]
        for i in range(count):
            out[i] += (a[i] * p[i] + b[i] * q[i]) + (c[i] * r[i] + e[i] * s[i])


@section
def _by_band(rows, compliances, y, scratch, out):
    """Product A y (k,), from the stored band of A."""
    band, above, inverse = compliances.band, rows.above, rows.inverse
    half = band.shape[1] // 2 - 1
    cx, cy, wx, wy = scratch.padded[0], scratch.padded[1], scratch.carried[0], scratch.carried[1]
    _solve(rows, y, cx, cy, half)
    _weighed(y.size, band[0], cx, wx)
    _weighed(y.size, band[band.shape[0] - 1], cy, wy)
    px, py = 0.0, 0.0
    for i in range(y.size):
        u, v = inverse[i], -above[i] * inverse[i]
        px, py = v * px + u * wx[i], v * py + u * wy[i]
        wx[i], wy[i] = px, py
    _finish(rows, wx, wy, out)
    for i in range(y.size):
        out[i] += compliances.stiff[i] * y[i]


@section
def product(rows, touched, compliances, y, scratch, out):
    """Changes of the gaps (k,) by forces y (k,), A y."""
    if compliances.band.shape[0] > 0:
        _by_band(rows, compliances, y, scratch, out)
    else:
        _through_nodes(rows, touched, compliances.soft, y, scratch, out)


@kernel
def band_of(rows, touched, soft, nodes):
    """B C B^T by diagonals for the first `nodes` touched nodes, which B has: (1 or 2, diagonals, k and zeros behind).

    Diagonals from -h to h and what fills their number up to a multiple of four: h = diagonals / 2 - 1. One layer
    if all nodes give way alike in x and y; none if the band is too wide.
    """
    count, local, row, weight = touched.own.size, touched.local, touched.row, rows.weight
    first, last, half, layers = np.empty(nodes, np.int32), np.empty(nodes, np.int32), 1, 1
    for z in range(local.size):
        last[local[z]] = row[z]
    for z in range(local.size - 1, -1, -1):
        first[local[z]] = row[z]
    for n in range(nodes):
        if soft[n, 0] == 0.0 and soft[n, 1] == 0.0:
            first[n] = -1  # of nodes that cannot move anything goes
        else:
            half = max(half, last[n] - first[n])
            if soft[n, 0] != soft[n, 1]:
                layers = 2
    if half > WIDEST:
        return np.empty((0, 4, count))
    # weights of each node in its first row and in later rows, as many for every node as any has: loops of one length
    width = half + 1
    entering = np.zeros((nodes, width))
    for z in range(local.size):
        n = local[z]
        if first[n] >= 0:
            entering[n, row[z] - first[n]] += weight[z]
    half |= 1
    band = np.zeros((layers, 2 * half + 2, count + width))
    for c in range(layers):
        for n in range(nodes):
            begin = first[n]
            if begin < 0:
                continue
            for k in range(width):
                w = soft[n, c] * entering[n, k]
                for j in range(k, width):
                    band[c, half + j - k, begin + k] += w * entering[n, j]
        for d in range(1, half + 1):
            below, above = band[c, half - d], band[c, half + d]
            for i in range(count - d):
                below[i + d] = above[i]
    return band
