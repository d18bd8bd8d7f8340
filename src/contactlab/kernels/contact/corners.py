"""Corners of the master on segments of the slave, and rows taken at them (`contactlab.contact.corners`)."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point

BESIDE = 0.05  # of a segment: allowed beyond inner ends, as at a turn of segments a corner may be above none
INSIDE = 0.02  # of a segment: margin within ends of the slave, as both sides may end together
AGAINST = -0.2  # cosine between the direction of a corner and the segment's normal


@point
def edge(at, segments, s):
    """Return the vector (x, y) along segment s and its length."""
    a, b = segments[s, 0], segments[s, 1]
    x, y = at[b, 0] - at[a, 0], at[b, 1] - at[a, 1]
    return x, y, np.sqrt(x * x + y * y)


@kernel
def touches(corners, start, above, slave, master, reach, segment, out):
    """Find the nearest segment that each corner is above or in, -1 for none, and its data.

    corners  (c,) nodes of the master; segments above[start[c]:start[c + 1]] of the slave may be near corner c
    slave, master  (positions (m, 2), segments, node_segments)
    reach    [mm] farther corners touch none
    segment  (c,) is filled, and out (c, 7): xi, gap, unit vector along the segment, outward normal, length
    """
    (at, segments, ends), (places, others, own) = slave, master
    count = 0
    for c in range(corners.size):
        v, nearest = corners[c], np.inf
        segment[c] = -1
        nx, ny = 0.0, 0.0
        for side in range(2):
            if own[v, side] >= 0:
                x, y, length = edge(places, others, own[v, side])
                nx, ny = nx + y / length, ny - x / length
        size = np.sqrt(nx * nx + ny * ny)
        for z in range(start[c], start[c + 1]):
            s = above[z]
            a, b = segments[s, 0], segments[s, 1]
            tx, ty, length = edge(at, segments, s)
            tx, ty = tx / length, ty / length
            dx, dy = places[v, 0] - at[a, 0], places[v, 1] - at[a, 1]
            xi, gap = (dx * tx + dy * ty) / length, dx * ty - dy * tx
            low = INSIDE if ends[a, 0] < 0 else -BESIDE
            high = 1.0 - INSIDE if ends[b, 1] < 0 else 1.0 + BESIDE
            if not (xi >= low and xi <= high and gap <= reach and gap >= -length):
                continue
            if not ty * nx - tx * ny < AGAINST * size:
                continue
            beyond = length * (xi - min(1.0, max(0.0, xi)))
            distance = gap * gap + beyond * beyond
            if distance < nearest:
                nearest, segment[c] = distance, s
                out[c, 0], out[c, 1], out[c, 2], out[c, 3] = xi, gap, tx, ty
                out[c, 4], out[c, 5], out[c, 6] = ty, -tx, length
        count += segment[c] >= 0
    return count


@point
def add(node, weight, tangent, count, n, values):
    """Add normal and tangential weights of node n to the weights of `count` nodes. Return the number of nodes."""
    z = 0
    while z < count and node[z] != n:
        z += 1
    if z == count:
        node[z], count = n, count + 1
        weight[z, 0], weight[z, 1], tangent[z, 0], tangent[z, 1] = 0.0, 0.0, 0.0, 0.0
    weight[z, 0] += values[0]
    weight[z, 1] += values[1]
    tangent[z, 0] += values[2]
    tangent[z, 1] += values[3]
    return count


@kernel
def take_row(start, node, weight, tangent, rows, own, other, shares, nodes, change):
    """Set row `own` of `rows` rows to its share plus the share of row `other`; nodes (3,) also get `change` (3, 2).

    Returns the number of entries gained by the row, or -1 without room. Without friction tangent is (0, 2).
    """
    rubs = tangent.shape[0] > 0
    most = start[own + 1] - start[own] + start[other + 1] - start[other] + nodes.size
    new_node, new_weight, new_tangent = np.empty(most, np.int32), np.empty((most, 2)), np.empty((most, 2))
    count = 0
    for part in range(2):
        row, share = (own, shares[0]) if part == 0 else (other, shares[1])
        for z in range(start[row], start[row + 1]):
            tx, ty = (share * tangent[z, 0], share * tangent[z, 1]) if rubs else (0.0, 0.0)
            values = share * weight[z, 0], share * weight[z, 1], tx, ty
            count = add(new_node, new_weight, new_tangent, count, node[z], values)
    for i in range(nodes.size):
        count = add(new_node, new_weight, new_tangent, count, nodes[i], (change[i, 0], change[i, 1], 0.0, 0.0))
    begin, end, last = start[own], start[own + 1], start[rows]
    more = count - (end - begin)
    if last + more > node.size:
        return -1
    for z in range(last - 1, end - 1, -1):
        node[z + more] = node[z]
        for c in range(2):
            weight[z + more, c] = weight[z, c]
            if rubs:
                tangent[z + more, c] = tangent[z, c]
    for z in range(count):
        node[begin + z] = new_node[z]
        for c in range(2):
            weight[begin + z, c] = new_weight[z, c]
            if rubs:
                tangent[begin + z, c] = new_tangent[z, c]
    for row in range(own + 1, rows + 1):
        start[row] += more
    return more
