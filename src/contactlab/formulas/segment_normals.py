"""Directions of contact: averaged normals of the slave, and normals of the master at ends and sharp turns of the slave.

The average of the normals of two segments by their lengths is the sum of both, turned and scaled. At an end or a vertex
it belongs to neither surface: the end of a beam drags on a plate along a normal that leans by the slope of the beam,
which friction sees; as a free side folds onto a die, the last node of the fold is pressed along a normal that leans by
half of the angle of the flanks. There forces act along the master's mean normal. Ends that lean by no more than the
surfaces turn from one segment to the next, as at planes of symmetry, keep their own: half of an even pressure on their
segment acts along it.

A view of a contact and its pieces are a `Both`, with the names of the contract.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Pieces, Surface
from contactlab.api.compiled.bound_arrays import Floats2, Ints1
from contactlab.api.compiled.dual import derivatives, seed
from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.mathematics import sqrt
from contactlab.api.tensors import Vector

LEAN = (0.25, 1.0)  # squared lean to the master's normal over its tolerance: none below, all above
LEAST = 0.004**2  # tolerance of the squared sine: 2 % of friction at mu = 0.2
TURN = (0.12**2, 0.2**2)  # squared sine by which the slave turns more than the master: none below, all above
SPREAD = 25.0  # weight of the squared sine of the master's turn within the overlap of a node, against its own


class At(NamedTuple):
    """Positions of the nodes of both sides [mm]."""

    slave: Floats2
    master: Floats2


class Near(NamedTuple):
    """Master segments near slave segment s: master[start[s]:start[s + 1]]."""

    start: Ints1
    master: Ints1


class View(NamedTuple):
    """A `ContactView`."""

    slave: Surface
    master: Surface
    at: At
    near: Near


class Both(NamedTuple):
    """A view, its pieces, and the numbers (n, 1) among the fields of the algorithm."""

    sides: View
    out: Pieces
    numbers: Floats2


# --- averages ---------------------------------------------------------------------------------------------------------


@kernel
def inward_normals(positions, segments, normals):
    """Compute averaged slave normals (m, 2), length-weighted and turned inward. Return the longest segment [mm]."""
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


@point
def neighbours(i, slave):
    """Return the nodes before and after node i of the slave: itself at ends of the chain."""
    before, after = slave.node_segments[i, 0], slave.node_segments[i, 1]
    return (slave.segments[before, 0] if before >= 0 else i), (slave.segments[after, 1] if after >= 0 else i)


@point
def edge_between(at, i, j):
    """Return the vector from node i to node j of positions (m, 2), by four coordinates: first of i, then of j."""
    return Vector(seed(at[j, 0], 2, 4) - seed(at[i, 0], 0, 4), seed(at[j, 1], 3, 4) - seed(at[i, 1], 1, 4))


@section
def average_derivatives(view, out):
    """Compute derivatives of averaged inward normals by the ends of the adjacent segments. Return their number."""
    e = 0
    for k in range(view.at.slave.shape[0]):
        nodes = neighbours(k, view.slave)
        normal = -edge_between(view.at.slave, nodes[0], nodes[1]).turned().unit()
        x, y = derivatives(normal.x, 4), derivatives(normal.y, 4)
        for q in range(4):
            out.normal_of[e], out.normal_moved[e] = k, 2 * nodes[q // 2] + q % 2
            out.dnormal[e, 0], out.dnormal[e, 1] = x[q], y[q]
            e += 1
    return e


# --- at ends and vertices ---------------------------------------------------------------------------------------------


@point
def ramp(value, low, high):
    """Return 0 below low, 1 above high, smooth between."""
    t = min(1.0, max(0.0, (value - low) / (high - low)))
    return t * t * (3.0 - 2.0 * t)


@point
def turn_between(before, here, after):
    """Return the squared sine of the angle by which a chain turns at a node: 1 beyond 90 degrees."""
    first, second = here - before, after - here
    found: float = 1.0
    if first @ second > 0.0:
        cross = first.cross(second)
        found = cross * cross / ((first @ first) * (second @ second))
    return found


@point
def node(at, i):
    """Return position i of an array (m, 2)."""
    return Vector(at[i, 0], at[i, 1])


@point
def is_end(i, slave):
    """Return whether the slave ends at node i."""
    return slave.node_segments[i, 0] < 0 or slave.node_segments[i, 1] < 0


@point
def turn_at(i, view):
    """Return the squared sine by which the slave turns at node i; 1 at its ends."""
    if is_end(i, view.slave):
        return 1.0
    before, after = neighbours(i, view.slave)
    return turn_between(node(view.at.slave, before), node(view.at.slave, i), node(view.at.slave, after))


@point
def beside_end(i, slave):
    """Return the node next to end i of the slave, -1 if this node is an end as well, or i is no end."""
    if not is_end(i, slave):
        return -1
    before, after = neighbours(i, slave)
    j = after if before == i else before
    return -1 if is_end(j, slave) else j


@point
def share_of_master(normal, facing, seen, turn, beside, end):
    """Return the master's share of the direction.

    normal  averaged inward normal of the slave at the node
    facing  sum of the master's outward normals, each by its overlap length with the multiplier
    seen    [mm] sum of these lengths
    turn, beside  squared sines by which the slave turns at the node and, if this is an end, next to it
    """
    square = facing @ facing
    spread = 1.0 - square / (seen * seen)
    found = ramp(turn - SPREAD * spread, TURN[0], TURN[1])
    if end:
        lean = normal.cross(facing)
        found = found * ramp(lean * lean / (square * (beside + 4.0 * spread + LEAST)), LEAN[0], LEAN[1])
    return found


@point
def direction(normal, facing, share):
    """Return the direction with a share of 0 to 1 of the master's normal."""
    return (normal + share * (facing / sqrt(facing @ facing) - normal)).unit()


@point
def length_seen(pieces, p, k):
    """Return the overlap length [mm] of multiplier k with piece p; 0 if the basis is negative there."""
    return max(0.0, pieces.T[p, 0, k] + pieces.T[p, 1, k])


@section
def sum_facing(view, pieces, count, wanted, facing):
    """Sum master normals over overlaps: (m, 3) of `facing` and `seen` if `wanted` (m,) is not zero."""
    facing[:] = 0.0
    for p in range(count):
        if wanted[pieces.multiplier[p, 0]] == 0.0 and wanted[pieces.multiplier[p, 1]] == 0.0:
            continue
        normal = (node(view.at.master, pieces.master[p, 1]) - node(view.at.master, pieces.master[p, 0])).turned().unit()
        for k in range(2):
            seen = length_seen(pieces, p, k)
            facing[pieces.multiplier[p, k], 0] += seen * normal.x
            facing[pieces.multiplier[p, k], 1] += seen * normal.y
            facing[pieces.multiplier[p, k], 2] += seen


@section
def turned(k, view, normals, facing):
    """Return the share of the master's normal at node k, given its sum over the overlap."""
    beside = beside_end(k, view.slave)
    if facing[k, 0] * facing[k, 0] + facing[k, 1] * facing[k, 1] == 0.0:
        return 0.0
    return share_of_master(
        node(normals, k), node(facing, k), facing[k, 2], turn_at(k, view),
        turn_at(beside, view) if beside >= 0 else 0.0, is_end(k, view.slave),
    )  # fmt: skip


@section
def turn_normals(view, pieces, count, normals):
    """Turn the averaged inward normals (m, 2) at ends and vertices to the master's. Return how many were turned."""
    turns, vertices, found = np.empty(normals.shape[0]), False, 0
    for k in range(normals.shape[0]):
        turns[k] = turn_at(k, view)
        vertices = vertices or turns[k] > TURN[0]
    if not vertices:
        return 0
    facing = np.empty((normals.shape[0], 3))
    sum_facing(view, pieces, count, turns, facing)
    for k in range(normals.shape[0]):
        share = turned(k, view, normals, facing) if turns[k] > TURN[0] else 0.0
        if share > 0.0:
            normal = direction(node(normals, k), node(facing, k), share)
            normals[k, 0], normals[k, 1] = normal.x, normal.y
            found += 1
    return found


@kernel
def turned_normals(bound, count, normals):
    """Call `turn_normals` for the first `count` pieces of a `Both` at the address `bound`."""
    both = unpack(bound, Both)
    return turn_normals(both.sides, both.out, count, normals)


# --- their derivatives ------------------------------------------------------------------------------------------------

NORMAL, FACING, SEEN, TURNS, BESIDE = 0, 2, 4, 5, 6  # the directions of derivatives, below


@section
def put_rates(k, view, averaged, facing, rates):
    """Compute derivatives of the direction of a turned node k by seven quantities into rates[k] (7, 2)."""
    beside = beside_end(k, view.slave)
    normal = Vector(seed(averaged[k, 0], 0, 8), seed(averaged[k, 1], 1, 8))
    sees = Vector(seed(facing[k, 0], 2, 8), seed(facing[k, 1], 3, 8))
    share = share_of_master(
        normal, sees, seed(facing[k, 2], 4, 8), seed(turn_at(k, view), 5, 8),
        seed(turn_at(beside, view) if beside >= 0 else 0.0, 6, 8), is_end(k, view.slave),
    )  # fmt: skip
    found = direction(normal, sees, share)
    x, y = derivatives(found.x, 7), derivatives(found.y, 7)
    for q in range(7):
        rates[k, q, 0], rates[k, q, 1] = x[q], y[q]


@section
def put(out, e, k, moved, x, y):
    """Write entry e: the normal of multiplier k changes by (x, y) with coordinate `moved`. Return the next entry."""
    out.normal_of[e], out.normal_moved[e] = k, moved
    out.dnormal[e, 0], out.dnormal[e, 1] = x, y
    return e + 1


@section
def by_master(view, pieces, count, out, piece, rates, is_turned, e):
    """Write entries by the master in the overlap: by lengths, and by its normals."""
    for c in range(piece.size):
        for j in range(2):
            k = out.multiplier[c, j]
            if is_turned[k] and length_seen(pieces, piece[c], j) > 0.0:
                a, b = node(view.at.master, out.master[c, 0]), node(view.at.master, out.master[c, 1])
                normal, longer, rate = (b - a).turned().unit(), out.dT[c, 0, j] + out.dT[c, 1, j], rates[k]
                x = longer * (rate[FACING, 0] * normal.x + rate[FACING + 1, 0] * normal.y + rate[SEEN, 0])
                y = longer * (rate[FACING, 1] * normal.x + rate[FACING + 1, 1] * normal.y + rate[SEEN, 1])
                e = put(out, e, k, out.moved[c], x, y)
    for p in range(count):
        for j in range(2):
            k = pieces.multiplier[p, j]
            if is_turned[k]:
                normal = edge_between(view.at.master, pieces.master[p, 0], pieces.master[p, 1]).turned().unit()
                seen, rate = length_seen(pieces, p, j), rates[k]
                u, v = derivatives(normal.x, 4), derivatives(normal.y, 4)
                for q in range(4):
                    moved = 2 * (view.at.slave.shape[0] + pieces.master[p, q // 2]) + q % 2
                    x = seen * (rate[FACING, 0] * u[q] + rate[FACING + 1, 0] * v[q])
                    y = seen * (rate[FACING, 1] * u[q] + rate[FACING + 1, 1] * v[q])
                    e = put(out, e, k, moved, x, y)
    return e


@section
def by_turn(view, k, j, rate, out, e):
    """Write entries of the turn at node j, an inner node; rate (2,): derivative of the direction of node k by it."""
    before, after = neighbours(j, view.slave)
    at = view.at.slave
    found = turn_between(
        Vector(seed(at[before, 0], 0, 8), seed(at[before, 1], 1, 8)),
        Vector(seed(at[j, 0], 2, 8), seed(at[j, 1], 3, 8)),
        Vector(seed(at[after, 0], 4, 8), seed(at[after, 1], 5, 8)),
    )
    changes = derivatives(found, 6)
    for q in range(6):
        moved = before if q < 2 else (j if q < 4 else after)
        e = put(out, e, k, 2 * moved + q % 2, changes[q] * rate[0], changes[q] * rate[1])
    return e


@section
def normal_derivatives(view, pieces, count, out, piece, averaged):
    """Compute derivatives of the directions of contact by node coordinates. Return the number of entries.

    piece     pieces of all derivatives of pieces in `out`
    averaged  (m, 2) averaged inward normals
    """
    m, e = averaged.shape[0], average_derivatives(view, out)
    facing, rates, is_turned = np.empty((m, 3)), np.empty((m, 7, 2)), np.zeros(m, np.bool_)
    sum_facing(view, pieces, count, np.ones(m), facing)
    some = False
    for k in range(m):
        is_turned[k] = turned(k, view, averaged, facing) > 0.0
        if is_turned[k]:
            put_rates(k, view, averaged, facing, rates)
            some = True
    if not some:
        return e
    for c in range(e):
        k = out.normal_of[c]
        if is_turned[k]:
            x, y, rate = out.dnormal[c, 0], out.dnormal[c, 1], rates[k]
            out.dnormal[c, 0] = rate[NORMAL, 0] * x + rate[NORMAL + 1, 0] * y
            out.dnormal[c, 1] = rate[NORMAL, 1] * x + rate[NORMAL + 1, 1] * y
    e = by_master(view, pieces, count, out, piece, rates, is_turned, e)
    for k in range(m):
        if is_turned[k]:
            if not is_end(k, view.slave):
                e = by_turn(view, k, k, rates[k, TURNS], out, e)
            elif beside_end(k, view.slave) >= 0:
                e = by_turn(view, k, beside_end(k, view.slave), rates[k, BESIDE], out, e)
    return e
