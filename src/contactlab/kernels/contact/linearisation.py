"""Nodal forces of a pair, and the effect of derivatives of segment contributions on its forces and gaps."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.pair import PairTable


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
