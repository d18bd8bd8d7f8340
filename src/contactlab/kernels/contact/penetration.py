"""Geometric penetration of points into a chain, measured without any contact algorithm."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.api.compiled.kernel import kernel


@kernel
def depths_behind(points, positions, segments, order, first, last, limit, out):
    """Compute the depth of every point behind its nearest segment; 0 outside, beyond chain ends or past `limit`.

    For each point, segments of `order` from `first` to `last` are checked.
    """
    for i in range(points.shape[0]):
        nearest, chosen, out[i] = limit, segments.shape[0], 0.0
        for k in range(first[i], last[i]):
            s = order[k]
            ax, ay = positions[segments[s, 0], 0], positions[segments[s, 0], 1]
            ex, ey = positions[segments[s, 1], 0] - ax, positions[segments[s, 1], 1] - ay
            length = np.sqrt(ex * ex + ey * ey)
            dx, dy = points[i, 0] - ax, points[i, 1] - ay
            xi = (dx * ex + dy * ey) / (length * length)
            if xi < 0.0 or xi > 1.0:
                continue
            gap = (dx * ey - dy * ex) / length
            # of two equally near segments, the first of the chain
            if abs(gap) < nearest or (abs(gap) == nearest and s < chosen and chosen < segments.shape[0]):
                nearest, chosen = abs(gap), s
                out[i] = max(0.0, -gap)


def depths(points: Floats, positions: Floats, segments: Ints, limit: float) -> Floats:
    """Return penetration (p,) [mm] of points (p, 2) into the body behind a chain, up to `limit`.

    Segments are sorted along the direction of the chain's spread, so that a point is tested only against segments
    within the search distance: time grows with the number of points and segments, not with their product.
    """
    out = np.empty(len(points))
    ends = positions[segments[:, :2]]
    along = int(np.argmax(np.ptp(ends.reshape(-1, 2), axis=0)))
    low, high = ends[:, :, along].min(axis=1), ends[:, :, along].max(axis=1)
    order, reach = np.argsort(low, kind="stable"), 1.001 * limit
    first = np.searchsorted(low[order], points[:, along] - reach - float((high - low).max()))
    last = np.searchsorted(low[order], points[:, along] + reach, side="right")
    args = (np.ascontiguousarray(points), np.ascontiguousarray(positions), segments, order, first, last)
    depths_behind(*args, limit, out)
    return out


def with_midpoints(positions: Floats, segments: Ints) -> Floats:
    """Return the chain's nodes and the middle of every segment (p, 2)."""
    middle = 0.5 * (positions[segments[:, 0]] + positions[segments[:, 1]])
    return np.concatenate([positions, middle])
