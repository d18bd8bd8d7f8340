"""Directions of contact at vertices of the slave: those of the master.

Where the slave is smooth, forces act along its averaged normals. At a vertex that average belongs to neither
flank: as a free side folds onto a die, the last node of the fold is pressed along a normal that leans by half of the
angle of the flanks, and the end of a cut corner along one that leans by nearly all of it. A vertex on a face is pressed
along the normal of the face.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point

LEAN = (0.2, 0.3)  # sine of the angle to the master's normal: none below, all above
TURN = (0.3, 0.5)  # sine by which the slave turns at a node: none below, all above; ends of chains turn by all


@point
def _ramp(value, low, high):
    """0 below low, 1 above high, smooth between."""
    t = min(1.0, max(0.0, (value - low) / (high - low)))
    return t * t * (3.0 - 2.0 * t)


@kernel
def slave_turn(i, positions, segments, node_segments):
    """Sine of the angle by which the slave turns at node i: 1 beyond 90 degrees and at ends of chains."""
    before, after = node_segments[i, 0], node_segments[i, 1]
    if before < 0 or after < 0:
        return 1.0
    a, b = segments[before, 0], segments[after, 1]
    ex, ey = positions[i, 0] - positions[a, 0], positions[i, 1] - positions[a, 1]
    fx, fy = positions[b, 0] - positions[i, 0], positions[b, 1] - positions[i, 1]
    if ex * fx + ey * fy <= 0.0:
        return 1.0
    return abs(ex * fy - ey * fx) / np.sqrt((ex * ex + ey * ey) * (fx * fx + fy * fy))


@kernel
def facing_sums(count, multiplier, master_nodes, T, master_at, wanted, facing):
    """Sum (m, 2) of the master's outward normals, each by the length over which a multiplier sees it.

    Only pieces that have to do with multipliers of which `wanted` (m,) is not zero are looked at.
    """
    for k in range(facing.shape[0]):
        facing[k, 0], facing[k, 1] = 0.0, 0.0
    for p in range(count):
        if wanted[multiplier[p, 0]] == 0.0 and wanted[multiplier[p, 1]] == 0.0:
            continue
        c, d = master_at[master_nodes[p, 0]], master_at[master_nodes[p, 1]]
        x, y = d[1] - c[1], c[0] - d[0]
        size = np.sqrt(x * x + y * y)
        for k in range(2):
            weight = (T[p, 0, k] + T[p, 1, k]) / size
            facing[multiplier[p, k], 0] += weight * x
            facing[multiplier[p, k], 1] += weight * y


@kernel
def turn_at_vertices(count, pieces, slave, slave_at, master_at, normals):
    """Turn the inward normals (m, 2) at vertices to the master's; returns how many were turned.

    pieces = (multipliers, master nodes, T), slave = (segments, node_segments)
    """
    multiplier, master_nodes, T = pieces
    segments, node_segments = slave
    vertices = False
    turns = np.empty(normals.shape[0])
    for k in range(normals.shape[0]):
        turns[k] = _ramp(slave_turn(k, slave_at, segments, node_segments), TURN[0], TURN[1])
        vertices = vertices or turns[k] > 0.0
    if not vertices:
        return 0
    facing, turned = np.empty(normals.shape), 0
    facing_sums(count, multiplier, master_nodes, T, master_at, turns, facing)
    for k in range(normals.shape[0]):
        size = np.sqrt(facing[k, 0] * facing[k, 0] + facing[k, 1] * facing[k, 1])
        if size == 0.0 or turns[k] == 0.0:
            continue
        x, y = facing[k, 0] / size, facing[k, 1] / size
        share = _ramp(abs(normals[k, 0] * y - normals[k, 1] * x), LEAN[0], LEAN[1])
        share *= turns[k]
        if share == 0.0:
            continue
        x, y = normals[k, 0] + share * (x - normals[k, 0]), normals[k, 1] + share * (y - normals[k, 1])
        size = np.sqrt(x * x + y * y)
        normals[k, 0], normals[k, 1] = x / size, y / size
        turned += 1
    return turned
