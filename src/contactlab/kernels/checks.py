"""Measures for guards: changing contact states, folded cells, and nodes deep in the other side."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel


@kernel
def status_changes(forces, pressed):
    """Find constraints (k,) that begin or cease to carry a force since `pressed` (k,) was filled, and renew it.

    Returns the number of changes, the number of constraints with a force now or then, a changed constraint, and
    the largest force.
    """
    changes, conditions, last, largest = 0, 0, -1, 0.0
    for k in range(forces.size):
        now = forces[k] > 0.0
        largest = max(largest, forces[k])
        if now or pressed[k]:
            conditions += 1
        if now != pressed[k]:
            changes += 1
            last = k
        pressed[k] = now
    return changes, conditions, last, largest


@kernel
def smallest_jacobian(geometry, connectivity, derivatives):
    """Return the smallest determinant of the cells' (a, B) maps at points with `derivatives` (q, a, 2); cell and point.

    The first NaN counts as the smallest.
    """
    worst, cell, point = np.inf, -1, -1
    nodes, cells = connectivity.shape
    for c in range(cells):
        for g in range(derivatives.shape[0]):
            x_xi, x_eta, y_xi, y_eta = 0.0, 0.0, 0.0, 0.0
            for i in range(nodes):
                n = connectivity[i, c]
                x_xi += derivatives[g, i, 0] * geometry[n, 0]
                x_eta += derivatives[g, i, 1] * geometry[n, 0]
                y_xi += derivatives[g, i, 0] * geometry[n, 1]
                y_eta += derivatives[g, i, 1] * geometry[n, 1]
            jacobian = x_xi * y_eta - x_eta * y_xi
            if not jacobian >= worst and not np.isnan(worst):
                worst, cell, point = jacobian, c, g
    return worst, cell, point


@kernel
def _signed_distance(x, y, ax, ay, bx, by):
    """Return the distance [mm] of a point from a segment's line, positive outside the body; NaN beyond its ends."""
    ex, ey = bx - ax, by - ay
    length = np.sqrt(ex * ex + ey * ey)
    along = ((x - ax) * ex + (y - ay) * ey) / (length * length)
    if along < 0.0 or along > 1.0:
        return np.nan
    return ((x - ax) * ey - (y - ay) * ex) / length


@kernel
def deepest(slave_at, slave_segments, master_at, master_segments, start, candidates, limit):
    """Find the deepest node of both sides behind its nearest segment of the other among the near segments.

    Only segments that face each other count, and depths up to `limit` [mm]. Returns the depth [mm], the node (a
    position in its surface) and 0 for a slave node or 1 for a master node.
    """
    own = np.full(slave_at.shape[0], np.inf)
    other = np.full(master_at.shape[0], np.inf)
    for s in range(slave_segments.shape[0]):
        i, j = slave_segments[s, 0], slave_segments[s, 1]
        for z in range(start[s], start[s + 1]):
            k, m = master_segments[candidates[z], 0], master_segments[candidates[z], 1]
            ex, ey = slave_at[j, 0] - slave_at[i, 0], slave_at[j, 1] - slave_at[i, 1]
            fx, fy = master_at[m, 0] - master_at[k, 0], master_at[m, 1] - master_at[k, 1]
            # 60 degrees off at most: the flank of a corner does not press on the other flank
            if ex * fx + ey * fy > -0.5 * np.sqrt((ex * ex + ey * ey) * (fx * fx + fy * fy)):
                continue
            for n in (i, j):
                d = _signed_distance(
                    slave_at[n, 0], slave_at[n, 1], master_at[k, 0], master_at[k, 1], master_at[m, 0], master_at[m, 1]
                )
                if abs(d) < abs(own[n]):
                    own[n] = d
            for n in (k, m):
                d = _signed_distance(
                    master_at[n, 0], master_at[n, 1], slave_at[i, 0], slave_at[i, 1], slave_at[j, 0], slave_at[j, 1]
                )
                if abs(d) < abs(other[n]):
                    other[n] = d
    depth, node, side = 0.0, -1, 0
    for n in range(own.size):
        if depth < -own[n] <= limit:
            depth, node, side = -own[n], n, 0
    for n in range(other.size):
        if depth < -other[n] <= limit:
            depth, node, side = -other[n], n, 1
    return depth, node, side
