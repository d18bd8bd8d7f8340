"""Projected Gauss-Seidel on gap rows: normal constraints, then the friction clip, row by row.

The rows of a few dozen constraints share most of their nodes: forming their dense compliance A = G C G^T once is then
cheaper than a second sweep over their entries, and a sweep is one vectorised update of all gaps per changed row. Normal
and tangential constraints of row k follow one another in A: 2 k and 2 k + 1 with friction, k without. Many rows are
swept as they are: `correction` (N, 2) [mm] is compliance times force, so that the gap of a row costs one pass over its
entries.

`rows` are `Rows` throughout. rows.work holds compliance and force of each row, normal (0, 1) and tangential (2, 3).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.friction import friction_limit
from contactlab.api.compiled.kernel import kernel, section
from contactlab_dynamics.factored_product import number_nodes


@kernel
def solve_dense(count, rows, compliance, multipliers, force, tolerance, limit):
    """Sweep over all rows in alternating directions; returns (sweeps, residual, rigid rows, largest correction).

    `rows` are `Rows`, the first `count` of them in use.
    """
    local = np.full(force.shape[0], -1, np.int32)
    touched = np.empty(force.shape[0], np.int32)
    nodes = number_nodes(rows.node[: rows.start[count]], local, touched, 0)
    conditions = count if rows.tangent_weight.shape[0] == 0 else 2 * count
    dense = np.zeros((conditions, conditions))
    _row_compliances(count, rows, compliance, local, nodes, dense)
    rigid = _warm_start(count, rows, multipliers)
    sweeps, residual = 0, 0.0
    if count > rigid:
        sweeps, residual = _dense_sweeps(count, rows, dense, tolerance, limit)
    _finish(count, rows, multipliers, force)
    return sweeps, residual, rigid, _largest_correction(touched[:nodes], compliance, force)


@kernel
def solve_sparse(count, rows, compliance, multipliers, force, tolerance, limit):
    """Solve as `solve_dense` does, without a dense matrix."""
    _row_diagonals(count, rows, compliance)
    rigid = _warm_start(count, rows, multipliers)
    sweeps, residual = 0, 0.0
    if count > rigid:
        sweeps, residual = _sparse_sweeps(count, rows, compliance, force, tolerance, limit)
    _finish(count, rows, multipliers, force)
    return sweeps, residual, rigid, _largest_correction(rows.node[: rows.start[count]], compliance, force)


@section
def _warm_start(count, rows, multipliers):
    """Forces to start from; returns the number of rows without compliance."""
    work, slot = rows.work, rows.slot
    rigid = 0
    for k in range(count):
        work[1, k] = multipliers[0, slot[k]] if work[0, k] > 0.0 else 0.0
        rigid += work[0, k] == 0.0
        if rows.tangent_weight.shape[0] > 0:
            work[3, k] = multipliers[1, slot[k]] if work[2, k] > 0.0 else 0.0
    return rigid


@section
def _add_force(begin, end, node, weight, amount, force):
    if amount != 0.0:
        for z in range(begin, end):
            force[node[z], 0] += weight[z, 0] * amount
            force[node[z], 1] += weight[z, 1] * amount


@kernel
def _largest_correction(node, compliance, force):
    """Largest displacement [mm] that the forces give to any of these nodes."""
    largest = 0.0
    for n in node:
        largest = max(largest, abs(compliance[n, 0] * force[n, 0]), abs(compliance[n, 1] * force[n, 1]))
    return largest


@section
def _finish(count, rows, multipliers, force):
    """Write multipliers to their slots, and forces to the nodes."""
    force[:] = 0.0
    multipliers[:] = 0.0
    for k in range(count):
        begin, end = rows.start[k], rows.start[k + 1]
        multipliers[0, rows.slot[k]] = rows.work[1, k]
        _add_force(begin, end, rows.node, rows.normal_weight, rows.work[1, k], force)
        if rows.tangent_weight.shape[0] > 0:
            multipliers[1, rows.slot[k]] = rows.work[3, k]
            _add_force(begin, end, rows.node, rows.tangent_weight, rows.work[3, k], force)


@section
def _normal_update(k, gap, rows):
    """y >= 0, g >= 0, y g = 0 of row k at its present gap; returns its natural residual before and the change."""
    a, y = rows.work[0, k], rows.work[1, k]
    new = max(0.0, y - gap / a)
    rows.work[1, k] = new
    return abs(min(gap, y * a)) / rows.size[k], new - y


@section
def _tangential_update(k, slip, rows):
    """No slip, or the force at the friction bound; returns row k's residual before and the change of its force."""
    a, y = rows.work[2, k], rows.work[3, k]
    limit = friction_limit(rows.bound[0, k], rows.bound[1, k], rows.bound[2, k], rows.measure[k], rows.work[1, k])
    new = min(limit, max(-limit, y - slip / a))
    rows.work[3, k] = new
    return abs(new - y) * a / rows.size[k], new - y


@section
def _weights(count, rows, local, columns):
    """Weights of all conditions by touched node and component: columns (touched, 2, conditions)."""
    normal, tangent = rows.normal_weight, rows.tangent_weight
    per_row = 2 if tangent.shape[0] > 0 else 1
    for k in range(count):
        for z in range(rows.start[k], rows.start[k + 1]):
            at = local[rows.node[z]]
            for c in range(2):
                columns[at, c, per_row * k] += normal[z, c]
                if per_row == 2:
                    columns[at, c, 2 * k + 1] += tangent[z, c]


@section
def _add_row(k, rows, weight, compliance, local, columns, width, row):
    """Add to row (conditions,) what each condition gains by a unit force of row k, the first `width` alone.

    `weight` are all normal weights, or all tangential ones
    """
    node, end = rows.node, rows.start[k + 1]
    z = rows.start[k]
    while z + 1 < end:  # two entries at a time: half the traffic of `row`
        n, m = node[z], node[z + 1]
        x, y = weight[z, 0] * compliance[n, 0], weight[z, 1] * compliance[n, 1]
        u, v = weight[z + 1, 0] * compliance[m, 0], weight[z + 1, 1] * compliance[m, 1]
        first, second = columns[local[n]], columns[local[m]]
        for j in range(width):
            row[j] += (x * first[0, j] + y * first[1, j]) + (u * second[0, j] + v * second[1, j])
        z += 2
    if z < end:
        n = node[z]
        x, y = weight[z, 0] * compliance[n, 0], weight[z, 1] * compliance[n, 1]
        first = columns[local[n]]
        for j in range(width):
            row[j] += x * first[0, j] + y * first[1, j]


@section
def _row_compliances(count, rows, compliance, local, nodes, dense):
    """Fill dense (conditions, conditions) [mm/N] with G C G^T, rows.work[0] and [2] with its diagonal."""
    size = dense.shape[0]
    columns = np.zeros((nodes, 2, size))
    _weights(count, rows, local, columns)
    per_row = 2 if rows.tangent_weight.shape[0] > 0 else 1
    for k in range(count):
        i = per_row * k
        _add_row(k, rows, rows.normal_weight, compliance, local, columns, i + 1, dense[i])
        if per_row == 2:
            _add_row(k, rows, rows.tangent_weight, compliance, local, columns, i + 2, dense[i + 1])
    for i in range(size):
        rows.work[2 * (i % per_row), i // per_row] = dense[i, i]
        for j in range(i):
            dense[j, i] = dense[i, j]


@section
def _dense_sweeps(count, rows, dense, tolerance, limit):
    """Sweep until the residual falls below `tolerance`; returns (sweeps, residual)."""
    normal_only = rows.tangent_weight.shape[0] == 0
    gaps = _present(count, rows, dense)
    per_row = 1 if normal_only else 2
    sweeps, residual = 0, np.inf
    while residual > tolerance and sweeps < limit:
        residual = 0.0
        for i in range(count):
            k = i if sweeps % 2 == 0 else count - 1 - i
            j = per_row * k
            if rows.work[0, k] > 0.0:
                found, change = _normal_update(k, gaps[j], rows)
                _move(dense[j], change, gaps)
                residual = max(residual, found)
            if not normal_only and rows.work[2, k] > 0.0:
                found, change = _tangential_update(k, gaps[j + 1], rows)
                _move(dense[j + 1], change, gaps)
                residual = max(residual, found)
        sweeps += 1
    return sweeps, residual


@section
def _present(count, rows, dense):
    """Gaps and slips under the forces of the warm start."""
    normal_only = rows.tangent_weight.shape[0] == 0
    per_row = 1 if normal_only else 2
    gaps = np.zeros(dense.shape[0])
    for k in range(count):
        gaps[per_row * k] = rows.gap[k]
        if not normal_only:
            gaps[2 * k + 1] = rows.slip[k]
    for k in range(count):
        _move(dense[per_row * k], rows.work[1, k], gaps)
        if not normal_only:
            _move(dense[2 * k + 1], rows.work[3, k], gaps)
    return gaps


@section
def _move(row, change, gaps):
    """Update all gaps and slips for a change of one force."""
    if change != 0.0:
        for j in range(gaps.size):
            gaps[j] += row[j] * change


@section
def _row_diagonals(count, rows, compliance):
    """Compliance of each row by its own force: rows.work[0], and [2] with friction."""
    for k in range(count):
        begin, end = rows.start[k], rows.start[k + 1]
        rows.work[0, k] = _row_compliance(begin, end, rows.node, rows.normal_weight, compliance)
        if rows.tangent_weight.shape[0] > 0:
            rows.work[2, k] = _row_compliance(begin, end, rows.node, rows.tangent_weight, compliance)


@section
def _row_compliance(begin, end, node, weight, compliance):
    total = 0.0
    for z in range(begin, end):
        n = node[z]
        total += weight[z, 0] * weight[z, 0] * compliance[n, 0] + weight[z, 1] * weight[z, 1] * compliance[n, 1]
    return total


@section
def _row_value(begin, end, node, weight, correction):
    """Sum of weight . correction over a row, in two chains that the processor can overlap."""
    even, odd = 0.0, 0.0
    z = begin
    while z + 1 < end:
        n, m = node[z], node[z + 1]
        even += weight[z, 0] * correction[n, 0] + weight[z, 1] * correction[n, 1]
        odd += weight[z + 1, 0] * correction[m, 0] + weight[z + 1, 1] * correction[m, 1]
        z += 2
    if z < end:
        n = node[z]
        even += weight[z, 0] * correction[n, 0] + weight[z, 1] * correction[n, 1]
    return even + odd


@section
def _push(begin, end, node, weight, amount, compliance, correction):
    if amount != 0.0:
        for z in range(begin, end):
            n = node[z]
            correction[n, 0] += compliance[n, 0] * weight[z, 0] * amount
            correction[n, 1] += compliance[n, 1] * weight[z, 1] * amount


@section
def _warm_correction(count, rows, compliance, correction):
    """Corrections that belong to the forces of the warm start."""
    correction[:] = 0.0
    for k in range(count):
        begin, end = rows.start[k], rows.start[k + 1]
        _push(begin, end, rows.node, rows.normal_weight, rows.work[1, k], compliance, correction)
        if rows.tangent_weight.shape[0] > 0:
            _push(begin, end, rows.node, rows.tangent_weight, rows.work[3, k], compliance, correction)


@section
def _sparse_sweeps(count, rows, compliance, correction, tolerance, limit):
    """Sweep until the residual falls below `tolerance`; returns (sweeps, residual)."""
    _warm_correction(count, rows, compliance, correction)
    node, normal, tangent = rows.node, rows.normal_weight, rows.tangent_weight
    sweeps, residual = 0, np.inf
    while residual > tolerance and sweeps < limit:
        residual = 0.0
        for i in range(count):
            # alternating directions keep a symmetric scene symmetric
            k = i if sweeps % 2 == 0 else count - 1 - i
            begin, end = rows.start[k], rows.start[k + 1]
            if rows.work[0, k] > 0.0:
                present = rows.gap[k] + _row_value(begin, end, node, normal, correction)
                found, change = _normal_update(k, present, rows)
                _push(begin, end, node, normal, change, compliance, correction)
                residual = max(residual, found)
            if tangent.shape[0] > 0 and rows.work[2, k] > 0.0:
                present = rows.slip[k] + _row_value(begin, end, node, tangent, correction)
                found, change = _tangential_update(k, present, rows)
                _push(begin, end, node, tangent, change, compliance, correction)
                residual = max(residual, found)
        sweeps += 1
    return sweeps, residual
