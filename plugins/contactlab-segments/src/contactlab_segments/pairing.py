"""Which master segment, or vertex, holds each slave node."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point, section

EDGE = 1e-9  # how far, in segment lengths, a node may project beyond a segment's end
LEAVE = 0.02  # the same at the ends of a chain, where nothing else holds it: bodies of one width spread differently
AT_END = 1e-6  # shares of a segment end within which a node sits on the vertex
HYSTERESIS = 1.02  # a new segment must be nearer by this factor: stops flicker at corners
SHARP = 0.17  # sine of the kink (10 degrees) from which a concave corner holds with both segments


@kernel
def _foot(p, segment, positions, segments, normal, length):
    """Gap [mm] and xi of point p on a segment's line."""
    a, b = segments[segment, 0], segments[segment, 1]
    dx, dy = p[0] - positions[a, 0], p[1] - positions[a, 1]
    gap = dx * normal[segment, 0] + dy * normal[segment, 1]
    along = dx * (positions[b, 0] - positions[a, 0]) + dy * (positions[b, 1] - positions[a, 1])
    return gap, along / (length[segment] * length[segment])


@point
def _beyond(segment, side, segments, node_segments):
    """How far a node may project beyond an end (0 or 1) of a segment."""
    return EDGE if node_segments[segments[segment, side], side] >= 0 else LEAVE


@kernel
def _nearest(
    p, outward, last, candidates, begin, end, positions, segments, node_segments, normal, length, reach, depth, best,
):  # fmt: skip
    """Nearest segment that p projects onto; best = (gap, xi). Returns -1 if there is none."""
    found = -1
    for z in range(begin, end):
        m = candidates[z]
        if outward[0] * normal[m, 0] + outward[1] * normal[m, 1] >= 0.0:
            continue
        gap, xi = _foot(p, m, positions, segments, normal, length)
        if gap > reach or gap < -depth:
            continue
        if xi < -_beyond(m, 0, segments, node_segments) or xi > 1.0 + _beyond(m, 1, segments, node_segments):
            continue
        measure = abs(gap) * (1.0 if m == last else HYSTERESIS)
        if found < 0 or measure < best[2]:
            found = m
            best[0], best[1], best[2] = gap, min(1.0, max(0.0, xi)), measure
    return found


@kernel
def _vertex(p, outward, candidates, begin, end, positions, segments, node_segments, normal, reach, best):
    """Nearest vertex between two segments when p projects onto neither; best = (distance, ., .)."""
    found = -1
    for z in range(begin, end):
        v = segments[candidates[z], 0]
        before = node_segments[v, 0]
        if before < 0:
            continue
        after = candidates[z]
        nx, ny = normal[before, 0] + normal[after, 0], normal[before, 1] + normal[after, 1]
        dx, dy = p[0] - positions[v, 0], p[1] - positions[v, 1]
        distance = np.sqrt(dx * dx + dy * dy)
        if outward[0] * nx + outward[1] * ny >= 0.0 or distance > reach:
            continue
        if found < 0 or distance < best[0]:
            found = v
            best[0] = distance
    return found


@kernel
def _put(p, node, slot, slots, weight, first, second, share, nx, ny, out):
    """Write one piece: tributary length `weight`, master nodes `first`, `second` with shares 1 - share, share."""
    slave_nodes, multipliers, master_nodes, D, M, T, normals = out
    k = slot * slots + node
    slave_nodes[p, 0] = node
    multipliers[p, 0] = k
    D[p, 0, 0], T[p, 0, 0] = weight, weight
    master_nodes[p, 0], master_nodes[p, 1] = first, second
    M[p, 0, 0], M[p, 1, 0] = (1.0 - share) * weight, share * weight
    if M.shape[1] == 3:
        master_nodes[p, 2], M[p, 2, 0] = first, 0.0
    normals[k, 0], normals[k, 1] = nx, ny


@kernel
def _put_on_parabola(count, node, point_at, slots, weight, positions, edge, s, out):
    """Write the piece of a node held by a quadratic edge (start, end, middle), at the closest point near s."""
    slave_nodes, multipliers, master_nodes, D, M, T, normals = out
    a, b, m = positions[edge[0]], positions[edge[1]], positions[edge[2]]
    for _ in range(8):
        x, y, tx, ty, cx, cy = _parabola(a, b, m, s)
        dx, dy = point_at[0] - x, point_at[1] - y
        slope = tx * tx + ty * ty - dx * cx - dy * cy
        change = (dx * tx + dy * ty) / slope if slope > 0.0 else 0.0
        s = min(1.0, max(-1.0, s + change))
        if abs(change) < 1e-14:
            break
    _, _, tx, ty, _, _ = _parabola(a, b, m, s)
    length = np.sqrt(tx * tx + ty * ty)
    slave_nodes[count, 0], multipliers[count, 0] = node, node
    D[count, 0, 0], T[count, 0, 0] = weight, weight
    for k in range(3):
        master_nodes[count, k] = edge[k]
    M[count, 0, 0] = 0.5 * s * (s - 1.0) * weight
    M[count, 1, 0] = 0.5 * s * (s + 1.0) * weight
    M[count, 2, 0] = (1.0 - s * s) * weight
    normals[node, 0], normals[node, 1] = ty / length, -tx / length


@point
def _parabola(a, b, m, s):
    """Position, first and second derivative by s of the edge through a (s = -1), m (0) and b (1)."""
    cx, cy = a[0] + b[0] - 2.0 * m[0], a[1] + b[1] - 2.0 * m[1]
    hx, hy = 0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1])
    return m[0] + s * (hx + 0.5 * s * cx), m[1] + s * (hy + 0.5 * s * cy), hx + s * cx, hy + s * cy, cx, cy


@kernel
def _hold_at_vertex(count, p, node, slots, weight, v, positions, segments, node_segments, normal, length, depth, out):
    """A convex vertex holds along the line to the node, a concave one with both its segments."""
    before, after = node_segments[v, 0], node_segments[v, 1]
    turn = normal[before, 0] * normal[after, 1] - normal[before, 1] * normal[after, 0]
    dx, dy = p[0] - positions[v, 0], p[1] - positions[v, 1]
    distance = np.sqrt(dx * dx + dy * dy)
    if turn < 0.0 and -turn > SHARP:
        for slot in range(2):
            m = before if slot == 0 else after
            share = 1.0 if slot == 0 else 0.0
            a, b = segments[m, 0], segments[m, 1]
            _put(count, node, slot, slots, weight, a, b, share, normal[m, 0], normal[m, 1], out)
            count += 1
        return count
    nx, ny = normal[before, 0] + normal[after, 0], normal[before, 1] + normal[after, 1]
    size = np.sqrt(nx * nx + ny * ny)
    outside = dx * nx + dy * ny >= 0.0
    if not outside and distance > depth:
        return count
    bx, by, cx, cy = normal[before, 0], normal[before, 1], normal[after, 0], normal[after, 1]
    # the line to the node is a normal only inside the wedge; next to the surface it could point anywhere
    if outside and distance > 0.0 and bx * dy - by * dx >= 0.0 and dx * cy - dy * cx >= 0.0:
        nx, ny = dx / distance, dy / distance
    else:
        nx, ny = nx / size, ny / size
    _put(count, node, 0, slots, weight, segments[after, 0], segments[after, 1], 0.0, nx, ny, out)
    return count + 1


@point
def _end_reached(share, m, segments, node_segments):
    """The vertex that a node sits on, -1 elsewhere: there neither segment's normal is better than the other's."""
    if share > AT_END and share < 1.0 - AT_END:
        return -1
    v = segments[m, 0] if share <= AT_END else segments[m, 1]
    return v if node_segments[v, 0] >= 0 and node_segments[v, 1] >= 0 else -1


@section
def _second_side(p, m, xi, positions, segments, node_segments, normal, length, reach):
    """The neighbour that holds the node too: p is in a sharp concave corner and projects onto both."""
    for side in range(2):
        v = segments[m, side]
        other = node_segments[v, side]
        if other < 0:
            continue
        first = m if side == 1 else other
        second = other if side == 1 else m
        turn = normal[first, 0] * normal[second, 1] - normal[first, 1] * normal[second, 0]
        if turn > -SHARP:
            continue
        gap, along = _foot(p, other, positions, segments, normal, length)
        if -EDGE <= along <= 1.0 + EDGE and abs(gap) <= reach:
            return other
    return -1


@kernel
def pair_nodes(
    slave_at, outward, tributary, slave_segments, positions, master, normal, length, near, reach, depth, memory, out,
):  # fmt: skip
    """Fill one piece per held node (two at sharp concave corners); returns their number.

    master = (segments, node_segments, edges, segment_edge)
    """
    segments, node_segments, edges, segment_edge = master
    start, candidates = near
    best = np.zeros(3)
    slots, count = slave_at.shape[0], 0
    for i in range(slots):
        p, last = slave_at[i], int(memory[i]) - 1
        found, distance = -1, np.inf
        share = 0.0
        for side in range(2):
            s = slave_segments[i, side]
            if s < 0:
                continue
            m = _nearest(p, outward[i], last, candidates, start[s], start[s + 1], positions, segments, node_segments,
                         normal, length, reach, depth, best)  # fmt: skip
            if m >= 0 and best[2] < distance:
                found, distance, share = m, best[2], best[1]
        memory[i] = found + 1
        if found >= 0:
            a, b = segments[found, 0], segments[found, 1]
            if edges.shape[1] == 3:
                s = share + segment_edge[found, 1] - 1.0
                _put_on_parabola(count, i, p, slots, tributary[i], positions, edges[segment_edge[found, 0]], s, out)
                count += 1
                continue
            v = _end_reached(share, found, segments, node_segments)
            if v >= 0:
                count = _hold_at_vertex(count, p, i, slots, tributary[i], v, positions, segments, node_segments,
                                        normal, length, depth, out)  # fmt: skip
                continue
            _put(count, i, 0, slots, tributary[i], a, b, share, normal[found, 0], normal[found, 1], out)
            count += 1
            other = _second_side(p, found, share, positions, segments, node_segments, normal, length, reach)
            if other >= 0:
                _, xi = _foot(p, other, positions, segments, normal, length)
                c, d = segments[other, 0], segments[other, 1]
                _put(count, i, 1, slots, tributary[i], c, d, xi, normal[other, 0], normal[other, 1], out)
                count += 1
            continue
        v, distance = -1, np.inf
        for side in range(2):
            s = slave_segments[i, side]
            if s < 0:
                continue
            at = _vertex(p, outward[i], candidates, start[s], start[s + 1], positions, segments, node_segments,
                         normal, reach, best)  # fmt: skip
            if at >= 0 and best[0] < distance:
                v, distance = at, best[0]
        if v >= 0 and edges.shape[1] == 3 and segment_edge[node_segments[v, 1], 1] == 1:
            # beside the kink of two half segments, where the true edge is smooth
            edge = edges[segment_edge[node_segments[v, 1], 0]]
            _put_on_parabola(count, i, p, slots, tributary[i], positions, edge, 0.0, out)
            count += 1
        elif v >= 0:
            count = _hold_at_vertex(count, p, i, slots, tributary[i], v, positions, segments, node_segments,
                                    normal, length, depth, out)  # fmt: skip
    return count
