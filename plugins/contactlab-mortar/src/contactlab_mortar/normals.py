"""Averaged normals of a slave, and their derivatives."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section


@kernel
def inward_normals(positions, segments, normals):
    """Averaged slave normals (m, 2), length-weighted and turned inward; returns the longest segment [mm].

    The average of the normals of two edges by their lengths is the sum of the edges, turned and scaled.
    """
    for i in range(normals.shape[0]):
        normals[i, 0], normals[i, 1] = 0.0, 0.0
    longest = 0.0
    for s in range(segments.shape[0]):
        a, b = segments[s, 0], segments[s, 1]
        x, y = positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1]
        longest = max(longest, x * x + y * y)
        normals[a, 0] -= y
        normals[a, 1] += x
        normals[b, 0] -= y
        normals[b, 1] += x
    for i in range(normals.shape[0]):
        x, y = normals[i, 0], normals[i, 1]
        size = 1.0 / np.sqrt(x * x + y * y)
        normals[i, 0], normals[i, 1] = x * size, y * size
    return np.sqrt(longest)


@kernel
def edge_sum(node, positions, segments, node_segments):
    """Sum of the edge vectors that meet at a slave node; the averaged normal is this turned by -90 degrees."""
    before, after = node_segments[node, 0], node_segments[node, 1]
    first = segments[before, 0] if before >= 0 else node
    last = segments[after, 1] if after >= 0 else node
    return positions[last, 0] - positions[first, 0], positions[last, 1] - positions[first, 1]


@section
def normal_derivatives(positions, segments, node_segments, out):
    """Derivatives of the inward normals by the ends of the edges that meet at each node; returns their number.

    out = (normal_of, normal_moved, dnormal)
    """
    normal_of, normal_moved, dnormal = out
    at = 0
    for k in range(positions.shape[0]):
        x, y = edge_sum(k, positions, segments, node_segments)
        size = np.sqrt(x * x + y * y)
        nx, ny = y / size, -x / size
        for end in range(2):
            beside = node_segments[k, end]
            node = segments[beside, end] if beside >= 0 else k
            for direction in range(2):
                # the unit vector (y, -x)/size changes across itself alone
                sign = (1.0 if end == 0 else -1.0) / size
                dx, dy = (0.0, -sign) if direction == 0 else (sign, 0.0)
                along = dx * nx + dy * ny
                normal_of[at], normal_moved[at] = k, 2 * node + direction
                dnormal[at, 0], dnormal[at, 1] = dx - along * nx, dy - along * ny
                at += 1
    return at
