"""Weights of nodes in the constraints of a pair, P = T^-T [D^T | -M^T], their forces, and the effect of their changes.

Row k holds the weights of surface nodes in constraint k, over its own stretch of the chain. Columns of T^-1 decay by a
constant factor per node (0.17 for P0, 0.27 for P1), so every row is cut as soon as its weights fall below `CUT`.
Derivatives of the integration segments change forces and gaps by dD, dM and dT (`contactlab.contact.linearisation`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api.compiled.bound_arrays import Floats1
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.coupling import Coupling, CouplingTable
from contactlab.kernels.contact.pair import BandedRows, PairTable

CUT = 1e-14  # a weight below it moves a gap by less than the round-off of the positions


def rows_of(coupling: Coupling, columns: BandedRows, rows: BandedRows) -> BandedRows:
    """Return rows of T^-T A^T from columns of A, in `rows` or in wider rows."""
    return _wide_enough(lambda out, room: solved(coupling.bound.address, columns, out, room), rows)


def inverse_rows(coupling: Coupling, rows: BandedRows) -> BandedRows:
    """Return rows of T^-T, in `rows` or in wider rows."""
    return _wide_enough(lambda out, room: inverse_transposed(coupling.bound.address, out, room), rows)


def _wide_enough(fill: Callable[[BandedRows, Floats1], int], rows: BandedRows) -> BandedRows:
    while needed := fill(rows, np.zeros(rows.weight.shape[1])):
        rows = BandedRows.allocate(len(rows.start), needed + needed // 2)
    return rows


@kernel
def _combine(k, other, factor, scale, rows, scratch):
    """Set row k to scale * (row k - factor * row other). Return 0 or the width it lacks."""
    start, end, weight = rows.start, rows.end, rows.weight
    low, high = start[other], end[other]
    cut = CUT / abs(factor * scale) if factor != 0.0 else 0.0
    if factor == 0.0:
        low = high
    while low < high and abs(weight[other, low - start[other]]) < cut:
        low += 1
    while high > low and abs(weight[other, high - 1 - start[other]]) < cut:
        high -= 1
    own, begin, finish = start[k], start[k], end[k]
    if low < high:
        begin, finish = min(begin, low), max(finish, high)
    if finish - begin > weight.shape[1]:
        return finish - begin
    for i in range(finish - begin):
        scratch[i] = 0.0
    for i in range(own, end[k]):
        scratch[i - begin] = scale * weight[k, i - own]
    shift, back, product = begin, start[other], scale * factor
    for i in range(low, high):
        scratch[i - shift] -= product * weight[other, i - back]
    for i in range(finish - begin):
        weight[k, i] = scratch[i]
    start[k], end[k] = begin, finish
    return 0


@section
def solve_rows(c, rows, scratch):
    """Turn columns of A into rows of T^-T A^T: both substitutions with T^T, whole rows at a time.

    `scratch` has as many numbers as a row may have weights. Returns 0, or the width that rows.weight lacks.
    """
    for i in range(c.kept[0]):
        k = c.order[i]
        p = c.previous[k]
        factor = c.upper[p] if p >= 0 else 0.0
        needed = _combine(k, p if p >= 0 else k, factor, 1.0 / c.pivot[k], rows, scratch)
        if needed > 0:
            return needed
    for i in range(c.kept[0] - 1, -1, -1):
        k = c.order[i]
        n = c.next[k]
        if n >= 0:
            needed = _combine(k, n, c.lower[n] / c.pivot[k], 1.0, rows, scratch)
            if needed > 0:
                return needed
    return 0


@kernel
def solved(bound, columns, rows, scratch):
    """Compute rows of T^-T A^T from columns of A. Return 0 or the width that rows.weight lacks.

    `bound` is the address of a `CouplingTable`.
    """
    needed = 0
    for k in range(rows.start.size):
        needed = max(needed, columns.end[k] - columns.start[k])
    if needed > rows.weight.shape[1]:
        return needed
    for k in range(rows.start.size):
        rows.start[k], rows.end[k] = columns.start[k], columns.end[k]
        for i in range(columns.end[k] - columns.start[k]):
            rows.weight[k, i] = columns.weight[k, i]
    return solve_rows(unpack(bound, CouplingTable), rows, scratch)


@kernel
def inverse_transposed(bound, rows, scratch):
    """Compute rows of T^-T. Return 0 or the width that rows.weight lacks. `bound`: address of a `CouplingTable`."""
    c = unpack(bound, CouplingTable)
    for i in range(c.kept[0]):
        k = c.order[i]
        rows.start[k], rows.end[k], rows.weight[k, 0] = k, k + 1, 1.0
    return solve_rows(c, rows, scratch)


@kernel
def own_nodes(bound, nodes, rows):
    """Write rows of constraints with weight on their own slave node alone, k modulo the number of nodes.

    `bound` is the address of a `CouplingTable`.
    """
    c = unpack(bound, CouplingTable)
    for i in range(c.kept[0]):
        k = c.order[i]
        rows.start[k], rows.end[k] = k % nodes, k % nodes + 1
        rows.weight[k, 0] = 1.0


@kernel
def entries(chosen, rows, cut, row, column, value):
    """Write entries (row, column, value) above `cut` of the chosen rows. Return their number."""
    at = 0
    for i in range(chosen.size):
        k = chosen[i]
        for z in range(rows.start[k], rows.end[k]):
            w = rows.weight[k, z - rows.start[k]]
            if abs(w) > cut:
                row[at], column[at], value[at] = k, z, w
                at += 1
    return at


# --- forces and flexibilities --------------------------------------------------------------------------------------


@kernel
def add_forces(bound, multipliers, first, normal_force, tangent_force):
    """Add the nodal forces of normal and of tangential multipliers to (N, 2) each (the latter may be empty).

    `bound` is the address of a `PairTable`, whose multipliers begin at `first`.
    """
    pair = unpack(bound, PairTable)
    _add_side(pair, pair.weights.slave, pair.places.slave, 1.0, multipliers[:, first:], normal_force, tangent_force)
    _add_side(pair, pair.weights.master, pair.places.master, -1.0, multipliers[:, first:], normal_force, tangent_force)


@section
def _add_side(pair, side, nodes, sign, multipliers, normal_force, tangent_force):
    c, normals, friction = pair.coupling, pair.pieces.normal, tangent_force.shape[0] > 0
    for i in range(c.kept[0]):
        k = c.order[i]
        y_n = multipliers[0, k]
        y_t = multipliers[1, k] if friction else 0.0
        if y_n == 0.0 and y_t == 0.0:
            continue
        nx, ny = normals[k, 0], normals[k, 1]
        for z in range(side.start[k], side.end[k]):
            w, n = sign * side.weight[k, z - side.start[k]], nodes[z]
            normal_force[n, 0] += w * y_n * nx
            normal_force[n, 1] += w * y_n * ny
            if friction:
                tangent_force[n, 0] += w * y_t * ny
                tangent_force[n, 1] -= w * y_t * nx


@kernel
def flexibilities(bound, nodal, out):
    """Sum squared normal weights times nodal flexibility (N, 2) into out (k,) for the kept multipliers.

    `bound` is the address of a `PairTable`.
    """
    pair = unpack(bound, PairTable)
    c, normals = pair.coupling, pair.pieces.normal
    for i in range(c.kept[0]):
        k = c.order[i]
        total = 0.0
        for side in range(2):
            weights = pair.weights.slave if side == 0 else pair.weights.master
            start, end, weight = weights.start, weights.end, weights.weight
            nodes = pair.places.slave if side == 0 else pair.places.master
            for z in range(start[k], end[k]):
                w, n = weight[k, z - start[k]], nodes[z]
                total += w * w * (normals[k, 0] ** 2 * nodal[n, 0] + normals[k, 1] ** 2 * nodal[n, 1])
        out[k] = total


# --- the effect of changing weights --------------------------------------------------------------------------------


@kernel
def _wanted(e, multiplier, owner, wanted):
    for j in range(multiplier.shape[1]):
        k = owner[multiplier[e, j]]
        if k >= 0 and wanted[k]:
            return True
    return False


@kernel
def _column(moved, nodes):
    slave_nodes, master_nodes = nodes
    v = moved // 2
    node = slave_nodes[v] if v < slave_nodes.size else master_nodes[v - slave_nodes.size]
    return 2 * node + moved % 2


@kernel
def _emit(at, row, column, value, out):
    if value == 0.0:
        return at
    out[0][at], out[1][at], out[2][at] = row, column, value
    return at + 1


@kernel
def force_derivatives(count, derivatives, owner, wanted, traction, nodes, force, coupling):
    """Compute derivatives of D a and -M a, and of T a, at fixed tractions a (k, 2); only for wanted multipliers.

    derivatives = (slave, multiplier, master, moved, dD, dM, dT), nodes = global nodes of slave and master;
    force and coupling = (row, column, value). Rows of `force` are degrees of freedom of the model, of `coupling`
    2 k + component; columns are degrees of freedom. Returns the number of entries of both.
    """
    slave, multiplier, master, moved, dD, dM, dT = derivatives
    slave_nodes, master_nodes = nodes
    at, given = 0, 0
    for e in range(count):
        if not _wanted(e, multiplier, owner, wanted):
            continue
        column = _column(moved[e], nodes)
        for c in range(2):
            for i in range(slave.shape[1]):
                total = 0.0
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[e, j]]
                    total += dD[e, i, j] * traction[k, c] if k >= 0 else 0.0
                at = _emit(at, 2 * slave_nodes[slave[e, i]] + c, column, total, force)
            for i in range(master.shape[1]):
                total = 0.0
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[e, j]]
                    total -= dM[e, i, j] * traction[k, c] if k >= 0 else 0.0
                at = _emit(at, 2 * master_nodes[master[e, i]] + c, column, total, force)
            for i in range(multiplier.shape[1]):
                row, total = owner[multiplier[e, i]], 0.0
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[e, j]]
                    total += dT[e, i, j] * traction[k, c] if k >= 0 else 0.0
                if row >= 0:
                    given = _emit(given, 2 * row + c, column, total, coupling)
    return at, given


@section
def weighted_change(e, j, c, derivatives, owner, at, separation):
    """Return the change by entry e of component c of the weighted gap D^T x - M^T y - T^T r of its multiplier j."""
    slave, multiplier, master, _, dD, dM, dT = derivatives
    slave_at, master_at = at
    total = 0.0
    for i in range(slave.shape[1]):
        total += dD[e, i, j] * slave_at[slave[e, i], c]
    for i in range(master.shape[1]):
        total -= dM[e, i, j] * master_at[master[e, i], c]
    for i in range(multiplier.shape[1]):
        other = owner[multiplier[e, i]]
        total -= dT[e, i, j] * separation[other, c] if other >= 0 else 0.0
    return total


@kernel
def gap_derivatives(count, derivatives, owner, wanted, at, separation, nodes, weight):
    """Compute derivatives of the weighted gaps D^T x - M^T y - T^T r at fixed positions and separations r (k, 2).

    at = positions of slave and master, nodes = their global numbers; weight = (row, column, value) with rows
    2 k + component. Returns the number of entries.
    """
    multiplier, moved, given = derivatives[1], derivatives[3], 0
    for e in range(count):
        if not _wanted(e, multiplier, owner, wanted):
            continue
        column = _column(moved[e], nodes)
        for j in range(multiplier.shape[1]):
            k = owner[multiplier[e, j]]
            if k < 0:
                continue
            for c in range(2):
                change = weighted_change(e, j, c, derivatives, owner, at, separation)
                given = _emit(given, 2 * k + c, column, change, weight)
    return given


@kernel
def add_weight_changes(count, derivatives, owner, traction, at, separation, nodes, force):
    """Add tractions a (k, 2) times derivatives of D^T x - M^T y - T^T r at fixed x, y, r to force (2N,)."""
    multiplier, moved = derivatives[1], derivatives[3]
    for e in range(count):
        total = 0.0
        for j in range(multiplier.shape[1]):
            k = owner[multiplier[e, j]]
            if k < 0:
                continue
            for c in range(2):
                if traction[k, c] != 0.0:
                    total += traction[k, c] * weighted_change(e, j, c, derivatives, owner, at, separation)
        force[_column(moved[e], nodes)] += total
