"""A contact pair from positions to gaps and rows, on its bound arrays: the work of `OperatorPair` in every step.

Rows are written out, G = T^-T [D^T | -M^T] . normal, or as columns of D and M and the coupling T: a row extends along
the whole contact, a column over the few nodes that share a segment with its multiplier. Columns and two substitutions
with T replace all products with rows in O(constraints).

k multipliers, m slave nodes, l master nodes; `bound` is the address of a `PairTable` throughout.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Pieces
from contactlab.api.compiled.bound_arrays import Floats2, Ints1, Ints2
from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.coupling import CouplingTable, couple, unmerged
from contactlab.kernels.contact.search import largest_move, take

FAR = 1e300  # gap of a multiplier that is not kept


class PlacesTable(NamedTuple):
    """Nodes and positions of a pair.

    slave, master           (m,), (l,) global nodes
    segments, node_segments of the slave
    slave_at, master_at     (m, 2), (l, 2) [mm] for the integration of D, M and T
    slave_measured, master_measured  [mm] for the measurement of gaps
    slave_before, master_before      [mm] of the near list
    """

    slave: Ints1
    master: Ints1
    segments: Ints2
    node_segments: Ints2
    slave_at: Floats2
    master_at: Floats2
    slave_measured: Floats2
    master_measured: Floats2
    slave_before: Floats2
    master_before: Floats2


class BandedRows(NamedTuple):
    """Rows with weights on one stretch of a chain of nodes each.

    Row k weights the positions start[k] <= p < end[k] by weight[k, p - start[k]].
    """

    start: Ints1
    end: Ints1
    weight: Floats2

    @classmethod
    def allocate(cls, rows: int, width: int) -> BandedRows:
        """Allocate empty rows of at most `width` weights."""
        return cls(np.zeros(rows, np.int32), np.zeros(rows, np.int32), np.zeros((rows, width)))


class BothSides(NamedTuple):
    """Banded rows over the slave's nodes and over the master's nodes, of one multiplier each."""

    slave: BandedRows
    master: BandedRows


class PairTable(NamedTuple):
    """All arrays of the kernels of one pair.

    columns     of D and M for each multiplier
    separation  (k, 2) [mm] weighted slave positions minus weighted master positions, gaps (k, 2) [mm] their normal and
                tangential parts
    weights     rows T^-T D^T and T^-T M^T
    """

    places: PlacesTable
    coupling: CouplingTable
    pieces: Pieces
    columns: BothSides
    separation: Floats2
    gaps: Floats2
    weights: BothSides


@section
def weigh(k, column, at, sign, x, y):
    """Return x and y plus sign times the weighted sum of positions `at` over column k."""
    start, end, weight = column.start, column.end, column.weight
    begin = start[k]
    for z in range(begin, end[k]):
        w = sign * weight[k, z - begin]
        x += w * at[z, 0]
        y += w * at[z, 1]
    return x, y


@kernel
def separations(c, columns, at, normals, separation, gaps):
    """Compute the vector from the master's to the slave's weighted position, its normal and tangential part (k, 2).

    at = positions of slave and master; dropped constraints count as `FAR` open.
    Both substitutions with T^T carry the last place of a chain in x and y, as `order` goes along the chains.
    """
    slave_at, master_at = at
    single, order, kept, nodes = c.single[0], c.order, c.kept[0], slave_at.shape[0]
    pivot, lower, upper, next_, previous = c.pivot, c.lower, c.upper, c.next, c.previous
    for k in range(gaps.shape[0]):
        gaps[k, 0] = FAR
    x, y = 0.0, 0.0
    for i in range(kept):
        k = order[i]
        u, v = weigh(k, columns.master, master_at, -1.0, 0.0, 0.0)
        if not single:
            u, v = weigh(k, columns.slave, slave_at, 1.0, u, v)
        p, inverse = previous[k], 1.0 / pivot[k]
        factor = upper[p] * inverse if p >= 0 else 0.0
        x, y = u * inverse - factor * x, v * inverse - factor * y
        separation[k, 0], separation[k, 1] = x, y
    x, y = 0.0, 0.0
    for i in range(kept - 1, -1, -1):
        k = order[i]
        n = next_[k]
        factor = lower[n] / pivot[k] if n >= 0 else 0.0
        x, y = separation[k, 0] - factor * x, separation[k, 1] - factor * y
        u, v = x, y
        if single:
            node = k % nodes
            u, v = u + slave_at[node, 0], v + slave_at[node, 1]
        nx, ny = normals[k, 0], normals[k, 1]
        separation[k, 0], separation[k, 1] = u, v
        gaps[k, 0], gaps[k, 1] = nx * u + ny * v, ny * u - nx * v


@kernel
def place(bound, positions, compliance, force, pushed):
    """Copy positions of surface nodes from all nodes (N, 2). Return their distance from the near list.

    Gaps belong to `positions`, and so do rows, unless they are `pushed` to positions + compliance * force.
    """
    pair = unpack(bound, PairTable)
    at = pair.places
    take(positions, at.slave, at.slave_measured)
    take(positions, at.master, at.master_measured)
    take(positions, at.slave, at.slave_at)
    take(positions, at.master, at.master_at)
    if pushed:
        _add_motion(compliance, force, at.slave, at.slave_at)
        _add_motion(compliance, force, at.master, at.master_at)
    c, full = pair.coupling, pair.coupling.full
    tributary_lengths(at.slave_at, at.segments, at.node_segments, full)
    for i in range(c.absent.size):  # half the length of nodes without multiplier goes to each adjacent node with one
        k = c.absent[i]
        full[c.following[k]] += 0.5 * full[k]
        full[c.preceding[k]] += 0.5 * full[k]
        full[k] = 0.0
    return max(largest_move(at.slave_at, at.slave_before), largest_move(at.master_at, at.master_before))


@kernel
def _add_motion(compliance, force, nodes, at):
    """Add compliance * force to the positions `at` of some nodes."""
    for i in range(nodes.size):
        n = nodes[i]
        for c in range(2):
            at[i, c] += compliance[n, c] * force[n, c]


@kernel
def fill_columns(count, multiplier, nodes, values, owner, out):
    """Fill columns of D or M for the kept multipliers from `count` contributions (p, b, w).

    Returns 0, or the width that out.weight lacks.
    """
    start, end, weight = out.start, out.end, out.weight
    width, rows = multiplier.shape[1], nodes.shape[1]
    for k in range(start.size):
        start[k], end[k] = 2147483647, 0
    if width == rows == 2:  # the common case, as constants: without inner loops
        _reach(count, 2, 2, multiplier, nodes, owner, out)
    else:
        _reach(count, width, rows, multiplier, nodes, owner, out)
    needed = 0
    for k in range(start.size):
        needed = max(needed, end[k] - start[k])
    if needed > weight.shape[1]:
        return needed
    for k in range(start.size):
        for i in range(needed):
            weight[k, i] = 0.0
    if width == rows == 2:
        _sum(count, 2, 2, multiplier, nodes, values, owner, out)
    else:
        _sum(count, width, rows, multiplier, nodes, values, owner, out)
    return 0


@section
def _reach(count, width, rows, multiplier, nodes, owner, out):
    """Widen the stretch of each kept multiplier to the nodes of its contributions."""
    start, end = out.start, out.end
    for p in range(count):
        low, high = nodes[p, 0], nodes[p, 0]
        for i in range(1, rows):
            low, high = min(low, nodes[p, i]), max(high, nodes[p, i])
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                start[k], end[k] = min(start[k], low), max(end[k], high + 1)


@section
def _sum(count, width, rows, multiplier, nodes, values, owner, out):
    """Add the contributions to the weights of the kept multipliers."""
    start, weight = out.start, out.weight
    for p in range(count):
        for j in range(width):
            k = owner[multiplier[p, j]]
            if k >= 0:
                shift = start[k]
                for i in range(rows):
                    weight[k, nodes[p, i] - shift] += values[p, i, j]


@kernel
def join(bound, count, straight):
    """Compute coupling, columns and gaps of the first `count` segment contributions.

    Returns (kept, width lacking in columns of D, in columns of M); gaps are valid if nothing lacks.
    kept is -1 if a closed chain overlaps all around. `straight`: every slave edge has two nodes.
    """
    pair = unpack(bound, PairTable)
    c, pieces, columns = pair.coupling, pair.pieces, pair.columns
    kept = couple(count, pieces.multiplier, pieces.T, c)
    if kept < 0:
        return kept, 0, 0
    single = straight and unmerged(c.owner, pieces.D, pieces.T, count)
    c.single[0] = single
    lacking = 0
    if not single:
        lacking = fill_columns(count, pieces.multiplier, pieces.slave, pieces.D, c.owner, columns.slave)
    missing = fill_columns(count, pieces.multiplier, pieces.master, pieces.M, c.owner, columns.master)
    if lacking == 0 and missing == 0:
        at = (pair.places.slave_measured, pair.places.master_measured)
        separations(c, columns, at, pieces.normal, pair.separation, pair.gaps)
    return kept, lacking, missing


@kernel
def compute_gaps_at(bound, at, normals, separation, gaps):
    """Compute separations and gaps (k, 2) of kept multipliers with other `normals`, at = slave and master positions."""
    pair = unpack(bound, PairTable)
    separations(pair.coupling, pair.columns, at, normals, separation, gaps)


# --- from gaps to rows ----------------------------------------------------------------------------------------------


@section
def _write(k, side, sign, numbers, normal, at, rows):
    """Write entries of one side of constraint k. Return the next free entry."""
    start, end, weight = side.start, side.end, side.weight
    nx, ny = sign * normal[0], sign * normal[1]
    shift = start[k]
    for z in range(start[k], end[k]):
        w = weight[k, z - shift]
        if w == 0.0:
            continue
        rows.node[at] = numbers[z]
        rows.normal_weight[at, 0], rows.normal_weight[at, 1] = w * nx, w * ny
        if rows.tangent_weight.shape[0] > 0:
            rows.tangent_weight[at, 0], rows.tangent_weight[at, 1] = w * ny, -w * nx
        at += 1
    return at


@kernel
def write_rows(bound, margin, multipliers, first_slot, row, at, rows):
    """Append constraints with a gap below `margin` or a force. Return (rows, entries), or (-1, 0) if out of room.

    bound  address of a `PairTable`
    rows   the model's `Rows`, of which `row` rows and `at` entries are in use
    """
    pair = unpack(bound, PairTable)
    c, gaps, normal = pair.coupling, pair.gaps, pair.pieces.normal
    slave, master = pair.weights.slave, pair.weights.master
    for i in range(c.kept[0]):
        k = c.order[i]
        if gaps[k, 0] >= margin and multipliers[0, first_slot + k] <= 0.0:
            continue
        room = slave.end[k] - slave.start[k] + master.end[k] - master.start[k]
        if row >= rows.gap.size or at + room > rows.node.size:
            return -1, 0
        rows.start[row] = at
        at = _write(k, slave, 1.0, pair.places.slave, normal[k], at, rows)
        at = _write(k, master, -1.0, pair.places.master, normal[k], at, rows)
        rows.start[row + 1] = at
        rows.gap[row], rows.measure[row], rows.size[row] = gaps[k, 0], c.cover[k], c.full[k]
        rows.slot[row] = first_slot + k
        row += 1
    return row, at


@kernel
def write_slips(first, last, first_slot, measured, current, rows):
    """Compute the slip of the step in rows first ... last - 1: tangent times separation now minus at the start.

    Each term has the tangent of its own time and both have the same weights (docs/theory/rows.md), so that a
    rigid rotation of the pair gives none. measured = gaps, normals and the normals at the start of the step, (k, 2)
    each; `current` (N, 2) are the positions at the start of the step.
    """
    gaps, normals, before = measured
    for row in range(first, last):
        k = rows.slot[row] - first_slot
        # tangent = (ny, -nx): the scalar weight is tangent . tangent_weight
        tx, ty = normals[k, 1], -normals[k, 0]
        x, y = 0.0, 0.0
        for z in range(rows.start[row], rows.start[row + 1]):
            w = rows.tangent_weight[z, 0] * tx + rows.tangent_weight[z, 1] * ty
            x += w * current[rows.node[z], 0]
            y += w * current[rows.node[z], 1]
        rows.slip[row] = gaps[k, 1] - (before[k, 1] * x - before[k, 0] * y)


@kernel
def tangential_work(count, rows, multipliers, mean_velocity, dt, compliance, force):
    """Return sums over the rows of y_t times mean sliding velocity times dt, and of -y_t times the slip at the end."""
    work, dissipated = 0.0, 0.0
    for row in range(count):
        y = multipliers[1, rows.slot[row]]
        if y == 0.0:
            continue
        sliding, end = 0.0, rows.slip[row]
        for z in range(rows.start[row], rows.start[row + 1]):
            n = rows.node[z]
            tx, ty = rows.tangent_weight[z, 0], rows.tangent_weight[z, 1]
            sliding += tx * mean_velocity[n, 0] + ty * mean_velocity[n, 1]
            end += tx * compliance[n, 0] * force[n, 0] + ty * compliance[n, 1] * force[n, 1]
        work += dt * y * sliding
        dissipated -= y * end
    return work, dissipated


@kernel
def extrapolate(now, before):
    """Extrapolate linearly forces (k,) that pressed in both last steps, never below zero; `before` becomes `now`."""
    for k in range(now.size):
        last = now[k]
        if last > 0.0 and before[k] > 0.0:
            now[k] = max(2.0 * last - before[k], 0.0)
        before[k] = last


@section
def _write_column(k, column, sign, numbers, at, node, weight):
    start, end, values = column.start, column.end, column.weight
    for z in range(start[k], end[k]):
        w = values[k, z - start[k]]
        if w != 0.0:
            node[at], weight[at] = numbers[z], sign * w
            at += 1
    return at


@kernel
def write_factored(bound, first_slot, row, out):
    """Append all constraints of a pair to the `row` rows of the model. Return their number, or -1 if out of room.

    bound  address of a `PairTable`
    out    `FactoredRows` of the model
    """
    pair = unpack(bound, PairTable)
    c, columns, slave, master = pair.coupling, pair.columns, pair.places.slave, pair.places.master
    single, normal, gaps = c.single[0], pair.pieces.normal, pair.gaps
    at = out.start[row]
    for i in range(c.kept[0]):
        k = c.order[i]
        room = columns.master.end[k] - columns.master.start[k]
        room += 0 if single else columns.slave.end[k] - columns.slave.start[k]
        if row >= out.gap.size or at + max(room, 0) > out.node.size:
            return -1
        at = _write_column(k, columns.master, -1.0, master, at, out.node, out.weight)
        if not single:
            at = _write_column(k, columns.slave, 1.0, slave, at, out.node, out.weight)
        p = c.previous[k]
        out.own[row] = slave[k % slave.size] if single else -1
        out.normal[row, 0], out.normal[row, 1] = normal[k, 0], normal[k, 1]
        out.gap[row], out.size[row], out.slot[row] = gaps[k, 0], c.full[k], first_slot + k
        out.above[row], out.below[row] = (c.upper[p], c.lower[k]) if p >= 0 else (0.0, 0.0)
        out.inverse[row] = 1.0 / c.pivot[k]
        row += 1
        out.start[row] = at
    return row
