"""Pieces of slave nodes that a segment, a quadratic edge or a vertex of the master holds.

All sections work on a `PairingTable` t; i is the slave node, p or count the piece that is written.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import point, section

SHARP = 0.17  # sine of the kink (10 degrees) from which a concave corner holds with both segments


@section
def put_piece(t, p, i, slot, m, share, normal):
    """Write one piece in row `slot` of its node: master segment m with shares 1 - share and share of its ends."""
    out, weight, k = t.pieces, t.tributary[i], slot * t.slave_at.shape[0] + i
    out.slave[p, 0], out.slave[p, 1] = i, i
    out.multiplier[p, 0] = k
    out.D[p, 0, 0], out.D[p, 1, 0], out.T[p, 0, 0] = weight, 0.0, weight
    out.master[p, 0], out.master[p, 1] = t.master.segments[m, 0], t.master.segments[m, 1]
    out.M[p, 0, 0], out.M[p, 1, 0] = (1.0 - share) * weight, share * weight
    if out.M.shape[1] == 3:
        out.master[p, 2], out.M[p, 2, 0] = t.master.segments[m, 0], 0.0
    out.normal[k, 0], out.normal[k, 1] = normal[0], normal[1]


@point
def parabola(a, b, m, s):
    """Position, first and second derivative by s of the edge through a (s = -1), m (0) and b (1)."""
    cx, cy = a[0] + b[0] - 2.0 * m[0], a[1] + b[1] - 2.0 * m[1]
    hx, hy = 0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1])
    return m[0] + s * (hx + 0.5 * s * cx), m[1] + s * (hy + 0.5 * s * cy), hx + s * cx, hy + s * cy, cx, cy


@section
def put_on_parabola(t, p, i, edge, s):
    """Write the piece of a node held by a quadratic edge (start, end, middle), at the closest point near s."""
    out, weight = t.pieces, t.tributary[i]
    nodes = t.master.edges[edge]
    a, b, m = t.master_at[nodes[0]], t.master_at[nodes[1]], t.master_at[nodes[2]]
    for _ in range(8):
        x, y, tx, ty, cx, cy = parabola(a, b, m, s)
        dx, dy = t.slave_at[i, 0] - x, t.slave_at[i, 1] - y
        slope = tx * tx + ty * ty - dx * cx - dy * cy
        change = (dx * tx + dy * ty) / slope if slope > 0.0 else 0.0
        s = min(1.0, max(-1.0, s + change))
        if abs(change) < 1e-14:
            break
    _, _, tx, ty, _, _ = parabola(a, b, m, s)
    length = np.sqrt(tx * tx + ty * ty)
    out.slave[p, 0], out.slave[p, 1], out.multiplier[p, 0] = i, i, i
    out.D[p, 0, 0], out.D[p, 1, 0], out.T[p, 0, 0] = weight, 0.0, weight
    for k in range(3):
        out.master[p, k] = nodes[k]
    out.M[p, 0, 0] = 0.5 * s * (s - 1.0) * weight
    out.M[p, 1, 0] = 0.5 * s * (s + 1.0) * weight
    out.M[p, 2, 0] = (1.0 - s * s) * weight
    out.normal[i, 0], out.normal[i, 1] = ty / length, -tx / length


@section
def hold_at_vertex(t, count, i, v, depth):
    """A convex vertex holds along the line to the node, a concave one with both segments; returns the next piece."""
    before, after = t.master.node_segments[v, 0], t.master.node_segments[v, 1]
    bx, by = t.master_normal[before, 0], t.master_normal[before, 1]
    cx, cy = t.master_normal[after, 0], t.master_normal[after, 1]
    if by * cx - bx * cy > SHARP:
        put_piece(t, count, i, 0, before, 1.0, (bx, by))
        put_piece(t, count + 1, i, 1, after, 0.0, (cx, cy))
        return count + 2
    dx, dy = t.slave_at[i, 0] - t.master_at[v, 0], t.slave_at[i, 1] - t.master_at[v, 1]
    distance = np.sqrt(dx * dx + dy * dy)
    nx, ny = bx + cx, by + cy
    size = np.sqrt(nx * nx + ny * ny)
    outside = dx * nx + dy * ny >= 0.0
    if not outside and distance > depth:
        return count
    # the line to the node is a normal only inside the wedge; next to the surface it could point anywhere
    if outside and distance > 0.0 and bx * dy - by * dx >= 0.0 and dx * cy - dy * cx >= 0.0:
        nx, ny = dx / distance, dy / distance
    else:
        nx, ny = nx / size, ny / size
    put_piece(t, count, i, 0, after, 0.0, (nx, ny))
    return count + 1
