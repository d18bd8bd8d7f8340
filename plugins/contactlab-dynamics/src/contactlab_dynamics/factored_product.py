"""Products with A = R C R^T, the effect of unit forces of `FactoredRows` on all gaps, in O(constraints).

R = E + T^-T B, E being the constraints' own slave nodes, is never formed. A product is two substitutions with T, the
matrix B C B^T between them, and two more. Constraints that share a node of B are neighbours, so that B C B^T is a
narrow band: once it is there, a product touches no node at all. If a node counts in E and in B, twice in E, or
joins constraints far apart, forces are spread over the nodes and their motions gathered instead.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.enforcement import FactoredRows

WIDEST = 24  # constraints to either side; wider bands cost more than going through the nodes


class Columns(NamedTuple):
    """`FactoredRows`, the first k of them in use, with the L nodes that they touch numbered among themselves.

    local, row  (z,) node and row of each entry; own (k,) the slave node of weight one in each row, -1 for none
    soft        (L, 2) [mm/N] motion of the nodes by a unit force
    band        (1 or 2, diagonals, k) [mm/N] B C B^T, none if it is too wide; stiff (k,) share of the own nodes
    padded      (2, k + diagonals) scratch, zero in the first h places and after the constraints' places
    carried     (2, k) scratch; nodal (L, 2) scratch, and nodal forces
    """

    rows: FactoredRows
    local: Ints
    row: Ints
    own: Ints
    soft: Floats
    band: Floats
    stiff: Floats
    padded: Floats
    carried: Floats
    nodal: Floats


@kernel
def number_nodes(node, local, touched, count):
    """List what of `node` is not yet among the first `count` of `touched`, and number it in `local` (N,).

    `local` is -1 where nothing has been numbered, negative nodes are skipped; returns the new count.
    """
    for n in node:
        if n >= 0 and local[n] < 0:
            local[n] = count
            touched[count] = n
            count += 1
    return count


@section
def held_columns(count, rows, compliance):
    """Return `Columns`, the L global nodes, and an estimate (k,) [mm/N] of each row's own compliance.

    The estimate is its slave node's compliance and the mean of its column's.
    """
    number, found = np.full(compliance.shape[0], -1, np.int32), np.empty(rows.start[count] + count, np.int32)
    entries = rows.start[count]
    columns = number_nodes(rows.node[:entries], number, found, 0)
    nodes = number_nodes(rows.own[:count], number, found, columns)
    local, row, own, once = np.empty(entries, np.int32), np.zeros(entries + 1, np.int32), np.empty(count, np.int32), 0
    for z in range(entries):
        local[z] = number[rows.node[z]]
    # every entry with its row: no processor predicts the end of loops over the few entries of a row
    for i in range(1, count):
        row[rows.start[i]] += 1
    for z in range(1, entries):
        row[z] += row[z - 1]
    for i in range(count):
        own[i] = number[rows.own[i]] if rows.own[i] >= 0 else -1
        once += own[i] >= 0
    soft, scale, stiff = np.empty((nodes, 2)), np.empty(count), np.zeros(count)
    for n in range(nodes):
        soft[n, 0], soft[n, 1] = compliance[found[n], 0], compliance[found[n], 1]
    for i in range(count):
        nx, ny = rows.normal[i, 0] * rows.normal[i, 0], rows.normal[i, 1] * rows.normal[i, 1]
        if own[i] >= 0:
            stiff[i] = nx * soft[own[i], 0] + ny * soft[own[i], 1]
        total, sum_ = 0.0, 0.0
        for z in range(rows.start[i], rows.start[i + 1]):
            w = abs(rows.weight[z])
            total += w * (nx * soft[local[z], 0] + ny * soft[local[z], 1])
            sum_ += w
        scale[i] = (total / sum_ if sum_ > 0.0 else 0.0) + stiff[i]
    # every own node counts once and in no column: nothing but the band joins constraints
    band = np.empty((0, 4, count))
    if columns + once == nodes:
        band = _band_of(count, rows, local, row[:entries], soft, columns)
    padded, carried = np.zeros((2, count + band.shape[1])), np.empty((2, count))
    held = Columns(rows, local, row[:entries], own, soft, band, stiff, padded, carried, np.empty((nodes, 2)))
    return held, found[:nodes], scale


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
def push_columns(held, y):
    """Write nodal forces R^T y on the touched nodes."""
    rows, nodal, normal, own, local, row = held.rows, held.nodal, held.rows.normal, held.own, held.local, held.row
    cx, cy = held.carried[0], held.carried[1]
    _solve(rows, y, cx, cy, 0)
    for n in range(nodal.shape[0]):
        nodal[n, 0], nodal[n, 1] = 0.0, 0.0
    for i in range(y.size):
        if own[i] >= 0:
            nodal[own[i], 0] += y[i] * normal[i, 0]
            nodal[own[i], 1] += y[i] * normal[i, 1]
    for z in range(local.size):
        n, i = local[z], row[z]
        nodal[n, 0] += rows.weight[z] * cx[i]
        nodal[n, 1] += rows.weight[z] * cy[i]


@kernel
def _through_nodes(held, y):
    """Compute B C R^T y in `carried`, by way of the motions of all touched nodes, which stay in `nodal`."""
    rows, nodal, soft, (wx, wy) = held.rows, held.nodal, held.soft, (held.carried[0], held.carried[1])
    push_columns(held, y)
    for n in range(nodal.shape[0]):
        nodal[n, 0], nodal[n, 1] = nodal[n, 0] * soft[n, 0], nodal[n, 1] * soft[n, 1]
    for i in range(y.size):
        x, y_ = 0.0, 0.0
        for z in range(rows.start[i], rows.start[i + 1]):
            x += rows.weight[z] * nodal[held.local[z], 0]
            y_ += rows.weight[z] * nodal[held.local[z], 1]
        wx[i], wy[i] = x, y_


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
def product_of_columns(held, y, out):
    """Compute changes of the gaps (k,) by forces y (k,), A y: by the band if there is one."""
    rows, band, normal, own, nodal = held.rows, held.band, held.rows.normal, held.own, held.nodal
    above, inverse, wx, wy, by_band = rows.above, rows.inverse, held.carried[0], held.carried[1], band.shape[0] > 0
    if by_band:
        cx, cy = held.padded[0], held.padded[1]
        _solve(rows, y, cx, cy, band.shape[1] // 2 - 1)
        _weighed(y.size, band[0], cx, wx)
        _weighed(y.size, band[band.shape[0] - 1], cy, wy)
    else:
        _through_nodes(held, y)
    px, py = 0.0, 0.0
    for i in range(y.size):
        u, v = inverse[i], -above[i] * inverse[i]
        px, py = v * px + u * wx[i], v * py + u * wy[i]
        wx[i], wy[i] = px, py
    _finish(rows, wx, wy, out)
    if by_band:
        for i in range(y.size):
            out[i] += held.stiff[i] * y[i]
    else:
        for i in range(y.size):
            if own[i] >= 0:
                out[i] += normal[i, 0] * nodal[own[i], 0] + normal[i, 1] * nodal[own[i], 1]


@kernel
def _band_of(count, rows, local, row, soft, nodes):
    """B C B^T by diagonals for the first `nodes` touched nodes, which B has: (1 or 2, diagonals, k and zeros behind).

    Diagonals from -h to h and what fills their number up to a multiple of four: h = diagonals / 2 - 1. One layer
    if all nodes give way alike in x and y; none if the band is too wide.
    """
    weight = rows.weight
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
