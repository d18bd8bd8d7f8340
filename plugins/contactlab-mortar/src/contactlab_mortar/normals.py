"""Averaged normals of a slave, and their derivatives."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.chains import nodal_normals, segment_normals
from contactlab.api.compiled.kernel import kernel, section


@kernel
def inward_normals(positions, segments, node_segments, normals):
    """Averaged slave normals (m, 2), length-weighted and turned inward; returns the longest segment [mm]."""
    normal, length = np.empty((segments.shape[0], 2)), np.empty(segments.shape[0])
    segment_normals(positions, segments, normal, length)
    nodal_normals(node_segments, normal, length, normals)
    for i in range(normals.shape[0]):
        normals[i, 0], normals[i, 1] = -normals[i, 0], -normals[i, 1]
    longest = 0.0
    for s in range(length.size):
        longest = max(longest, length[s])
    return longest


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
