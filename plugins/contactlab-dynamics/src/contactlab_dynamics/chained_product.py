"""Products with A = R C R^T, what unit forces of chained conditions do to all gaps, in O(conditions).

R = E + T^-T B, E being the conditions' own slave nodes, is never formed. A product is two substitutions with T, the
matrix B C B^T between them, and two more. Conditions that share a node of B are neighbours, so that B C B^T is a
narrow band: once it is there, a product touches no node at all. Where a node counts in E and in B, twice in E, or
joins conditions far apart, forces are spread over the nodes and their motions gathered instead.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.kernel import kernel, section

WIDEST = 24  # conditions to either side; wider bands cost more than going through the nodes


@section
def _solve(count, normal, above, below, inverse, y, cx, cy, pad):
    """T^-1 of the forces y times their normals, from position `pad` of cx and cy on.

    In all substitutions what depends on the last place comes first in its sum: one fused multiply-add per place then
    is the whole chain of dependences, about half of what it is the other way round.
    """
    px, py = 0.0, 0.0
    for i in range(count):
        v = -below[i] * inverse[i - 1] if i > 0 else 0.0
        px, py = v * px + y[i] * normal[i, 0], v * py + y[i] * normal[i, 1]
        cx[pad + i], cy[pad + i] = px, py
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(count - 1, -1, -1):
        u, v = inverse[i], -factor * inverse[i]
        px, py = v * px + u * cx[pad + i], v * py + u * cy[pad + i]
        cx[pad + i], cy[pad + i] = px, py
        factor = above[i]


@section
def _finish(count, normal, below, inverse, wx, wy, out):
    """Gaps (k,): the normal parts of T^-T w, of which the first substitution is done."""
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(count - 1, -1, -1):
        v = -factor * inverse[i]
        px, py = v * px + wx[i], v * py + wy[i]
        out[i] = normal[i, 0] * px + normal[i, 1] * py
        factor = below[i]


@kernel
def spread(count, start, local, weight, own, normal, above, below, inverse, y, carried, nodal):
    """Nodal forces R^T y on the touched nodes, (L, 2). `carried` (2, k) is scratch."""
    for n in range(nodal.shape[0]):
        nodal[n, 0], nodal[n, 1] = 0.0, 0.0
    cx, cy = carried[0], carried[1]
    _solve(count, normal, above, below, inverse, y, cx, cy, 0)
    for i in range(count):
        n = own[i]
        if n >= 0:
            nodal[n, 0] += y[i] * normal[i, 0]
            nodal[n, 1] += y[i] * normal[i, 1]
        x, y_ = cx[i], cy[i]
        for z in range(start[i], start[i + 1]):
            n = local[z]
            nodal[n, 0] += weight[z] * x
            nodal[n, 1] += weight[z] * y_


@kernel
def _through_nodes(count, start, local, weight, own, normal, above, below, inverse, soft, y, carried, nodal, out):
    """A y by the motions of all touched nodes."""
    spread(count, start, local, weight, own, normal, above, below, inverse, y, carried, nodal)
    for n in range(nodal.shape[0]):
        nodal[n, 0], nodal[n, 1] = nodal[n, 0] * soft[n, 0], nodal[n, 1] * soft[n, 1]
    wx, wy = carried[0], carried[1]
    px, py = 0.0, 0.0
    for i in range(count):
        x, y_ = 0.0, 0.0
        for z in range(start[i], start[i + 1]):
            x += weight[z] * nodal[local[z], 0]
            y_ += weight[z] * nodal[local[z], 1]
        u, v = inverse[i], -above[i] * inverse[i]
        px, py = v * px + u * x, v * py + u * y_
        wx[i], wy[i] = px, py
    _finish(count, normal, below, inverse, wx, wy, out)
    for i in range(count):
        if own[i] >= 0:
            out[i] += normal[i, 0] * nodal[own[i], 0] + normal[i, 1] * nodal[own[i], 1]


@kernel
def _by_band(count, band, stiff, normal, above, below, inverse, y, padded, carried, out):
    """A y by the band (layers, k, 2 h + 1), `stiff` (k,) being the share of the own nodes.

    `padded` (2, k + 2 h) is scratch, zero in the first and last h places.
    """
    half, other = band.shape[2] // 2, band.shape[0] - 1
    cx, cy, wx, wy = padded[0], padded[1], carried[0], carried[1]
    _solve(count, normal, above, below, inverse, y, cx, cy, half)
    px, py = 0.0, 0.0
    for i in range(count):
        x, y_ = 0.0, 0.0
        for d in range(band.shape[2]):
            x += band[0, i, d] * cx[i + d]
            y_ += band[other, i, d] * cy[i + d]
        u, v = inverse[i], -above[i] * inverse[i]
        px, py = v * px + u * x, v * py + u * y_
        wx[i], wy[i] = px, py
    _finish(count, normal, below, inverse, wx, wy, out)
    for i in range(count):
        out[i] += stiff[i] * y[i]


@kernel
def product(
    count, start, local, weight, own, normal, above, below, inverse, soft, band, stiff, y, padded, carried, nodal, out
):  # fmt: skip
    """Changes of the gaps (k,) by forces y (k,), A y."""
    if band.shape[0] > 0:
        _by_band(count, band, stiff, normal, above, below, inverse, y, padded, carried, out)
    else:
        _through_nodes(
            count, start, local, weight, own, normal, above, below, inverse, soft, y, carried, nodal, out
        )  # fmt: skip


@kernel
def band_of(count, start, local, weight, soft, nodes):
    """B C B^T about its diagonal, (1 or 2, k, 2 h + 1), for the first `nodes` touched ones, those of B.

    One layer where all nodes give way alike in x and y. Without any layer where the band were too wide.
    """
    first, last = np.full(nodes, count), np.full(nodes, -1)
    for i in range(count):
        for z in range(start[i], start[i + 1]):
            n = local[z]
            first[n], last[n] = min(first[n], i), max(last[n], i)
    half, layers = 0, 1
    for n in range(nodes):
        if soft[n, 0] != 0.0 or soft[n, 1] != 0.0:
            half = max(half, last[n] - first[n])
        if soft[n, 0] != soft[n, 1]:
            layers = 2
    if half > WIDEST:
        return np.empty((0, count, 1))
    band = np.zeros((layers, count, 2 * half + 1))
    entering = np.zeros((nodes, half + 1))
    for i in range(count):
        for z in range(start[i], start[i + 1]):
            n = local[z]
            if i - first[n] <= half:  # of nodes that cannot move anything goes
                entering[n, i - first[n]] += weight[z]
    for c in range(layers):
        for n in range(nodes):
            if soft[n, c] == 0.0:
                continue
            begin, size = first[n], last[n] - first[n] + 1
            for k in range(size):
                w, at = soft[n, c] * entering[n, k], half - k
                for j in range(size):
                    band[c, begin + k, at + j] += w * entering[n, j]
    return band
