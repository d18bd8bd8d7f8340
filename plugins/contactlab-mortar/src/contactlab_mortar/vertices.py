"""Directions of contact at ends and vertices of the slave: those of the master.

Where the slave is smooth, forces act along its averaged normals. At an end or a vertex that average belongs to neither
surface: the end of a beam drags on a plate along a normal that leans by the beam's slope, which friction sees; as a
free side folds onto a die, the last node of the fold is pressed along a normal that leans by half of the angle of the
flanks. There forces act along the master's mean normal. Ends that lean by no more than the surfaces turn from one
segment to the next, as at planes of symmetry, keep their own: half of an even pressure on their segment acts along it.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point

LEAN = (0.25, 1.0)  # squared lean to the master's normal over what is no lean yet: none below, all above
LEAST = 0.004**2  # squared sine that is no lean: 2 % of friction at mu = 0.2
TURN = (0.12**2, 0.2**2)  # squared sine by which the slave turns more than the master: none below, all above
SPREAD = 25.0  # of the squared sine by which the master turns within what a node sees, against its own


@point
def ramp(value, low, high):
    """0 below low, 1 above high, smooth between."""
    t = min(1.0, max(0.0, (value - low) / (high - low)))
    return t * t * (3.0 - 2.0 * t)


@point
def turn(i, positions, segments, node_segments):
    """Squared sine of the angle by which the slave turns at node i: 1 beyond 90 degrees and at ends of chains."""
    before, after = node_segments[i, 0], node_segments[i, 1]
    if before < 0 or after < 0:
        return 1.0
    a, b = segments[before, 0], segments[after, 1]
    ex, ey = positions[i, 0] - positions[a, 0], positions[i, 1] - positions[a, 1]
    fx, fy = positions[b, 0] - positions[i, 0], positions[b, 1] - positions[i, 1]
    if ex * fx + ey * fy <= 0.0:
        return 1.0
    cross = ex * fy - ey * fx
    return cross * cross / ((ex * ex + ey * ey) * (fx * fx + fy * fy))


@point
def is_end(i, node_segments):
    """Whether the slave ends at node i."""
    return node_segments[i, 0] < 0 or node_segments[i, 1] < 0


@point
def beside_end(i, segments, node_segments):
    """The node beside end i of the slave, -1 where that is an end as well."""
    before, after = node_segments[i, 0], node_segments[i, 1]
    j = segments[after, 1] if before < 0 else segments[before, 0]
    return -1 if is_end(j, node_segments) else j


@point
def lean_ratio(i, cross, seen, positions, segments, node_segments):
    """Squared lean (sine) of end i to the master's normal over what is no lean yet; and that."""
    j = beside_end(i, segments, node_segments)
    free = (turn(j, positions, segments, node_segments) if j >= 0 else 0.0) + 4.0 * (1.0 - seen) + LEAST
    return cross * cross / free, free


@kernel
def facing_sums(count, multiplier, master_nodes, T, master_at, wanted, facing):
    """Sum (m, 2) of the master's outward normals, each by the length over which a multiplier sees it, and of lengths.

    Only pieces that have to do with multipliers of which `wanted` (m,) is not zero are looked at.
    """
    for k in range(facing.shape[0]):
        facing[k, 0], facing[k, 1], facing[k, 2] = 0.0, 0.0, 0.0
    for p in range(count):
        if wanted[multiplier[p, 0]] == 0.0 and wanted[multiplier[p, 1]] == 0.0:
            continue
        c, d = master_at[master_nodes[p, 0]], master_at[master_nodes[p, 1]]
        x, y = d[1] - c[1], c[0] - d[0]
        size = np.sqrt(x * x + y * y)
        for k in range(2):
            seen = T[p, 0, k] + T[p, 1, k]
            facing[multiplier[p, k], 0] += seen * x / size
            facing[multiplier[p, k], 1] += seen * y / size
            facing[multiplier[p, k], 2] += seen


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
        turns[k] = turn(k, slave_at, segments, node_segments)
        vertices = vertices or turns[k] > TURN[0]
    if not vertices:
        return 0
    facing, turned = np.empty((normals.shape[0], 3)), 0
    facing_sums(count, multiplier, master_nodes, T, master_at, turns, facing)
    for k in range(normals.shape[0]):
        square = facing[k, 0] * facing[k, 0] + facing[k, 1] * facing[k, 1]
        if square == 0.0 or turns[k] <= TURN[0]:
            continue
        size, seen = np.sqrt(square), square / (facing[k, 2] * facing[k, 2])
        x, y = facing[k, 0] / size, facing[k, 1] / size
        share = ramp(turns[k] - SPREAD * (1.0 - seen), TURN[0], TURN[1])
        if is_end(k, node_segments):
            lean = normals[k, 0] * y - normals[k, 1] * x
            share *= ramp(lean_ratio(k, lean, seen, slave_at, segments, node_segments)[0], LEAN[0], LEAN[1])
        if share == 0.0:
            continue
        x, y = normals[k, 0] + share * (x - normals[k, 0]), normals[k, 1] + share * (y - normals[k, 1])
        size = np.sqrt(x * x + y * y)
        normals[k, 0], normals[k, 1] = x / size, y / size
        turned += 1
    return turned
