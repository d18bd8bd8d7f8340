"""Geometric penetration of points into a chain, measured without any contact algorithm."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.api.compiled.kernel import kernel


@kernel
def depths_behind(points, positions, segments, limit, out):
    """Depth of every point behind its nearest segment; 0 outside, beyond the chain's ends or past `limit`."""
    for i in range(points.shape[0]):
        nearest, out[i] = limit, 0.0
        for s in range(segments.shape[0]):
            ax, ay = positions[segments[s, 0], 0], positions[segments[s, 0], 1]
            ex, ey = positions[segments[s, 1], 0] - ax, positions[segments[s, 1], 1] - ay
            length = np.sqrt(ex * ex + ey * ey)
            dx, dy = points[i, 0] - ax, points[i, 1] - ay
            xi = (dx * ex + dy * ey) / (length * length)
            if xi < 0.0 or xi > 1.0:
                continue
            gap = (dx * ey - dy * ex) / length
            if abs(gap) < nearest:
                nearest = abs(gap)
                out[i] = max(0.0, -gap)


def depths(points: Floats, positions: Floats, segments: Ints, limit: float) -> Floats:
    """Penetration (p,) [mm] of points (p, 2) into the body behind a chain, up to `limit` deep."""
    out = np.empty(len(points))
    depths_behind(np.ascontiguousarray(points), np.ascontiguousarray(positions), segments, limit, out)
    return out


def with_midpoints(positions: Floats, segments: Ints) -> Floats:
    """The chain's nodes and the middle of every segment (p, 2)."""
    middle = 0.5 * (positions[segments[:, 0]] + positions[segments[:, 1]])
    return np.concatenate([positions, middle])
