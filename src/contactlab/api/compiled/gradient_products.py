"""Products with rows before their coupling T is inverted, G u and G^T y, in O(constraints).

`FactoredGradients` are G_i = normal . (own + [T^-T B])_i + spin d(angle), B in blocks of two by two. An angle belongs
to the averaged normal of a slave node; it turns by turn . (u_after - u_before), u the motions of the nodes on both
sides. `FactoredRows` have no angles, and weights for blocks. The first k constraints are in use.

In all substitutions what depends on the last place comes first in its sum: one fused multiply-add per place then is the
whole chain of dependences, about half of what it is the other way round.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import section, table_kernel


@section
def divide(rows, wx, wy):
    """Overwrite w (k,) by T^-1 w, for both components. `rows` are `FactoredRows`."""
    inverse, above, below, last = rows.inverse, rows.above, rows.below, wx.size - 1
    px, py = 0.0, 0.0
    for i in range(wx.size):
        v = -below[i] * inverse[i - 1] if i > 0 else 0.0
        px, py = v * px + wx[i], v * py + wy[i]
        wx[i], wy[i] = px, py
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(last, -1, -1):
        u, v = inverse[i], -factor * inverse[i]
        px, py = v * px + u * wx[i], v * py + u * wy[i]
        wx[i], wy[i] = px, py
        factor = above[i]


@section
def finish_transposed(rows, wx, wy):
    """Overwrite w (k,) by T^-T x if w is x after the first substitution. `rows` are `FactoredRows`."""
    inverse, below = rows.inverse, rows.below
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(wx.size - 1, -1, -1):
        v = -factor * inverse[i]
        px, py = v * px + wx[i], v * py + wy[i]
        wx[i], wy[i] = px, py
        factor = below[i]


@table_kernel
def conditions_moved(rows, count, nodal, turned, carried, out):
    """Compute changes G u of the gaps (k,) by `nodal` motions (L, 2); scratch: `turned` (a,), `carried` (2, k)."""
    f, block, angles, lever, angle_start = rows.factors, rows.block, rows.angle, rows.lever, rows.angle_start
    start, node, own, normal, inverse, above = f.start, f.node, f.own, f.normal, f.inverse, f.above
    ends, turn, spin, own_angle = rows.ends, rows.turn, rows.spin, rows.own_angle
    px, py, wx, wy = 0.0, 0.0, carried[0][:count], carried[1][:count]
    for a in range(rows.used[1]):
        b, c = ends[a, 0], ends[a, 1]
        turned[a] = turn[a, 0] * (nodal[c, 0] - nodal[b, 0]) + turn[a, 1] * (nodal[c, 1] - nodal[b, 1])
    for i in range(count):
        x, y = 0.0, 0.0
        for z in range(start[i], start[i + 1]):
            ux, uy = nodal[node[z], 0], nodal[node[z], 1]
            x += block[z, 0, 0] * ux + block[z, 0, 1] * uy
            y += block[z, 1, 0] * ux + block[z, 1, 1] * uy
        for z in range(angle_start[i], angle_start[i + 1]):
            angle = turned[angles[z]]
            x += lever[z, 0] * angle
            y += lever[z, 1] * angle
        u, v = inverse[i], -above[i] * inverse[i]
        px, py = v * px + u * x, v * py + u * y
        wx[i], wy[i] = px, py
    finish_transposed(f, wx, wy)
    for i in range(count):
        x, y = wx[i], wy[i]
        if own[i] >= 0:
            x, y = x + nodal[own[i], 0], y + nodal[own[i], 1]
        out[i] = normal[i, 0] * x + normal[i, 1] * y + spin[i] * turned[own_angle[i]]


@table_kernel
def nodes_pushed(rows, y, nodal, moment, carried):
    """Write nodal forces G^T y to `nodal` (L, 2) by forces y (k,); `moment` (a,) and `carried` (2, k) are scratch."""
    f, count = rows.factors, y.size
    block, angles, lever, angle_start = rows.block, rows.angle, rows.lever, rows.angle_start
    start, node, own, normal = f.start, f.node, f.own, f.normal
    ends, turn, spin, own_angle = rows.ends, rows.turn, rows.spin, rows.own_angle
    wx, wy = carried[0][:count], carried[1][:count]
    for n in range(rows.used[0]):
        nodal[n, 0], nodal[n, 1] = 0.0, 0.0
    for a in range(rows.used[1]):
        moment[a] = 0.0
    for i in range(count):
        wx[i], wy[i] = y[i] * normal[i, 0], y[i] * normal[i, 1]
        if own[i] >= 0:
            nodal[own[i], 0] += wx[i]
            nodal[own[i], 1] += wy[i]
        moment[own_angle[i]] += spin[i] * y[i]
    divide(f, wx, wy)
    for i in range(count - 1, -1, -1):
        px, py = wx[i], wy[i]
        for z in range(start[i], start[i + 1]):
            n = node[z]
            nodal[n, 0] += block[z, 0, 0] * px + block[z, 1, 0] * py
            nodal[n, 1] += block[z, 0, 1] * px + block[z, 1, 1] * py
        for z in range(angle_start[i], angle_start[i + 1]):
            moment[angles[z]] += lever[z, 0] * px + lever[z, 1] * py
    for a in range(rows.used[1]):
        b, c, m = ends[a, 0], ends[a, 1], moment[a]
        nodal[b, 0] -= turn[a, 0] * m
        nodal[b, 1] -= turn[a, 1] * m
        nodal[c, 0] += turn[a, 0] * m
        nodal[c, 1] += turn[a, 1] * m
