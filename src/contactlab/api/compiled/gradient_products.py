"""Products with the rows of `FactoredGradients`, G u and G^T y, in O(constraints).

G_i = normal . (own + [T^-T B])_i + spin d(angle), B in blocks of two by two. An angle belongs to the averaged normal of
a slave node; it turns by turn . (u_after - u_before), u the motions of the nodes on both sides.
`rows` are `FactoredGradients` throughout, of which the first k constraints are in use.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import table_kernel


@table_kernel
def conditions_moved(rows, count, nodal, turned, carried, out):
    """Compute changes G u of the gaps (k,) by `nodal` motions (L, 2); scratch: `turned` (a,), `carried` (2, k)."""
    f, block, angles, lever, angle_start = rows.factors, rows.block, rows.angle, rows.lever, rows.angle_start
    start, node, own, normal, inverse, above, below = f.start, f.node, f.own, f.normal, f.inverse, f.above, f.below
    ends, turn, spin, own_angle = rows.ends, rows.turn, rows.spin, rows.own_angle
    for a in range(rows.used[1]):
        b, c = ends[a, 0], ends[a, 1]
        turned[a] = turn[a, 0] * (nodal[c, 0] - nodal[b, 0]) + turn[a, 1] * (nodal[c, 1] - nodal[b, 1])
    px, py, wx, wy = 0.0, 0.0, carried[0], carried[1]
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
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(count - 1, -1, -1):
        v = -factor * inverse[i]
        px, py = v * px + wx[i], v * py + wy[i]
        x, y = px, py
        if own[i] >= 0:
            x, y = x + nodal[own[i], 0], y + nodal[own[i], 1]
        out[i] = normal[i, 0] * x + normal[i, 1] * y + spin[i] * turned[own_angle[i]]
        factor = below[i]


@table_kernel
def nodes_pushed(rows, y, nodal, moment, carried):
    """Fill nodal forces G^T y, `nodal` (L, 2), by forces y (k,); `moment` (a,) and `carried` (2, k) are scratch."""
    f, count = rows.factors, y.size
    block, angles, lever, angle_start = rows.block, rows.angle, rows.lever, rows.angle_start
    start, node, own, normal, inverse, above, below = f.start, f.node, f.own, f.normal, f.inverse, f.above, f.below
    ends, turn, spin, own_angle = rows.ends, rows.turn, rows.spin, rows.own_angle
    for n in range(rows.used[0]):
        nodal[n, 0], nodal[n, 1] = 0.0, 0.0
    for a in range(rows.used[1]):
        moment[a] = 0.0
    px, py, cx, cy = 0.0, 0.0, carried[0], carried[1]
    for i in range(count):
        v = -below[i] * inverse[i - 1] if i > 0 else 0.0
        x, y_ = y[i] * normal[i, 0], y[i] * normal[i, 1]
        px, py = v * px + x, v * py + y_
        cx[i], cy[i] = px, py
        if own[i] >= 0:
            nodal[own[i], 0] += x
            nodal[own[i], 1] += y_
        moment[own_angle[i]] += spin[i] * y[i]
    px, py, factor = 0.0, 0.0, 0.0
    for i in range(count - 1, -1, -1):
        u, v = inverse[i], -factor * inverse[i]
        px, py = v * px + u * cx[i], v * py + u * cy[i]
        factor = above[i]
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
