"""Normals and lengths of chains of straight segments, compiled. The body lies on the left of each segment."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel

__all__ = ["nodal_normals", "segment_normals", "tributary_lengths"]


@kernel
def segment_normals(positions, segments, normals, lengths):
    """Compute outward unit normals (s, 2), the tangent turned by -90 degrees, and lengths (s,) [mm]."""
    for s in range(segments.shape[0]):
        a, b = segments[s, 0], segments[s, 1]
        tx, ty = positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1]
        length = np.sqrt(tx * tx + ty * ty)
        lengths[s] = length
        normals[s, 0] = ty / length
        normals[s, 1] = -tx / length


@kernel
def nodal_normals(node_segments, segment_normal, lengths, normals):
    """Compute length-weighted averages (m, 2) of the unit normals of the segments that meet at a node."""
    for i in range(node_segments.shape[0]):
        x, y = 0.0, 0.0
        for side in range(2):
            s = node_segments[i, side]
            if s >= 0:
                x += lengths[s] * segment_normal[s, 0]
                y += lengths[s] * segment_normal[s, 1]
        size = np.sqrt(x * x + y * y)
        normals[i, 0] = x / size
        normals[i, 1] = y / size


@kernel
def tributary_lengths(positions, segments, node_segments, out):
    """Write half the length [mm] of the segments at each of m nodes, `slots` times, into `out` (slots * m,)."""
    m = node_segments.shape[0]
    for i in range(m):
        total = 0.0
        for side in range(2):
            s = node_segments[i, side]
            if s >= 0:
                a, b = segments[s, 0], segments[s, 1]
                x, y = positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1]
                total += 0.5 * np.sqrt(x * x + y * y)
        for k in range(i, out.size, m):
            out[k] = total
