"""Derivatives of segment contributions by differences, for algorithms that give none.

Nodes that no contribution depends on together are moved together (colours), so that a few evaluations of the
algorithm give the derivatives of all contributions.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Ints1
from contactlab.api.compiled.kernel import kernel

JUMP = 2.0  # a change larger than the change to the other side by this factor is a kink or a jump


class Move(NamedTuple):
    """The nodes of one colour moved along one direction.

    following, preceding  (m,) neighbours on the moved surface, -1 at ends
    colours    (m,) of its nodes
    ring       further nodes on both sides of a contribution that it may depend on
    shift      number of the surface's first node among the nodes of both
    colour, direction, scale  the motion, and one over the length between both evaluations [1/mm]
    """

    following: Ints1
    preceding: Ints1
    colours: Ints1
    ring: int
    shift: int
    colour: int
    direction: int
    scale: float


@kernel
def _ends(nodes, p, size):
    """Return first and last of a contribution's nodes along the chain of `size` nodes, which may pass its start."""
    low, high = nodes[p, 0], nodes[p, 0]
    for i in range(1, nodes.shape[1]):
        low, high = min(low, nodes[p, i]), max(high, nodes[p, i])
    if 2 * (high - low) <= size or high - low < nodes.shape[1]:
        return low, high
    first, last = high, low
    for i in range(nodes.shape[1]):
        n = nodes[p, i]
        if 2 * n > size:
            first = min(first, n)
        else:
            last = max(last, n)
    return first, last


@kernel
def moved_node(nodes, p, move):
    """Return the node of the moved colour that contribution p may depend on, its own or a ring on both sides; or -1."""
    v, beyond = _ends(nodes, p, move.colours.size)
    for _ in range(move.ring):
        if move.preceding[v] >= 0:
            v = move.preceding[v]
        if move.following[beyond] >= 0:
            beyond = move.following[beyond]
    for _ in range(move.colours.size):
        if move.colours[v] == move.colour:
            return v
        if v == beyond or move.following[v] < 0:
            return -1
        v = move.following[v]
    return -1


@kernel
def _alike(p, first, q, second):
    """Return whether contribution p of one set and q of the other couple the same nodes and multipliers."""
    for side in range(3):
        one, other = first[:3][side], second[:3][side]
        for i in range(one.shape[1]):
            if one[p, i] != other[q, i]:
                return False
    return True


@kernel
def _put(at, scale, p, pieces, moved, out):
    """Set entry `at` to scale * contribution p."""
    slave, multiplier, master, D, M, T = pieces
    o_slave, o_multiplier, o_master, o_moved, dD, dM, dT = out
    for i in range(slave.shape[1]):
        o_slave[at, i] = slave[p, i]
        for j in range(multiplier.shape[1]):
            dD[at, i, j] = scale * D[p, i, j]
    for i in range(master.shape[1]):
        o_master[at, i] = master[p, i]
        for j in range(multiplier.shape[1]):
            dM[at, i, j] = scale * M[p, i, j]
    for i in range(multiplier.shape[1]):
        o_multiplier[at, i] = multiplier[p, i]
        for j in range(multiplier.shape[1]):
            dT[at, i, j] = scale * T[p, i, j]
    o_moved[at] = moved


@kernel
def _take_off(at, scale, q, pieces, out):
    """Subtract scale * contribution q from entry `at`; False if the result is zero."""
    D, M, T = pieces[3], pieces[4], pieces[5]
    dD, dM, dT = out[4], out[5], out[6]
    left = 0.0
    for j in range(dT.shape[2]):
        for i in range(dD.shape[1]):
            dD[at, i, j] -= scale * D[q, i, j]
            left = max(left, abs(dD[at, i, j]))
        for i in range(dM.shape[1]):
            dM[at, i, j] -= scale * M[q, i, j]
            left = max(left, abs(dM[at, i, j]))
        for i in range(dT.shape[1]):
            dT[at, i, j] -= scale * T[q, i, j]
            left = max(left, abs(dT[at, i, j]))
    return left > 0.0


@kernel
def differences(high_count, high, low_count, low, side, move, at, out):
    """Append scale * (high - low) for the contributions that depend on the moved nodes.

    high, low = (slave, multiplier, master, D, M, T) of both evaluations, `side` 0 or 2: side of the moved nodes.
    Contributions of only one evaluation are entries of their own. Returns the next free entry.
    """
    high_nodes, low_nodes = (high[0], low[0]) if side == 0 else (high[2], low[2])
    head = 0
    while head < min(high_count, low_count) and _alike(head, high, head, low):
        head += 1
    tail = 0
    while tail < min(high_count, low_count) - head and _alike(high_count - 1 - tail, high, low_count - 1 - tail, low):
        tail += 1
    for p in range(high_count):
        v = moved_node(high_nodes, p, move)
        if v < 0:
            continue
        _put(at, move.scale, p, high, 2 * (move.shift + v) + move.direction, out)
        if p < head or p >= high_count - tail:
            q = p if p < head else p - high_count + low_count
            if _take_off(at, move.scale, q, low, out):
                at += 1
        else:
            at += 1
    for q in range(head, low_count - tail):
        v = moved_node(low_nodes, q, move)
        if v >= 0:
            _put(at, -move.scale, q, low, 2 * (move.shift + v) + move.direction, out)
            at += 1
    return at


@kernel
def normal_differences(high, middle, low, owners, move, at, out):
    """Append scale * (high - low) of the normals (k, 2); `owners` (k, b) are surface nodes of each multiplier.

    If a normal jumps, as between two segments, the side without the jump is used.
    out = (normal_of, normal_moved, dnormal). Returns the next free entry.
    """
    normal_of, normal_moved, dnormal = out
    scale = move.scale
    for k in range(high.shape[0]):
        ahead = max(abs(high[k, 0] - middle[k, 0]), abs(high[k, 1] - middle[k, 1]))
        behind = max(abs(middle[k, 0] - low[k, 0]), abs(middle[k, 1] - low[k, 1]))
        x, y = scale * (high[k, 0] - low[k, 0]), scale * (high[k, 1] - low[k, 1])
        if ahead > JUMP * behind:
            x, y = 2.0 * scale * (middle[k, 0] - low[k, 0]), 2.0 * scale * (middle[k, 1] - low[k, 1])
        elif behind > JUMP * ahead:
            x, y = 2.0 * scale * (high[k, 0] - middle[k, 0]), 2.0 * scale * (high[k, 1] - middle[k, 1])
        if (x == 0.0 and y == 0.0) or owners[k, 0] < 0:
            continue
        v = moved_node(owners, k, move)
        if v < 0:
            continue
        normal_of[at], normal_moved[at] = k, 2 * (move.shift + v) + move.direction
        dnormal[at, 0], dnormal[at, 1] = x, y
        at += 1
    return at
