"""Projected Gauss-Seidel on the dense compliance of the rows, A = G C G^T.

Row weights of a mortar reach along the whole contact, so that one sweep over the entries costs as much as a
good part of forming A. With A at hand a sweep is one vectorised update of all gaps per changed row.
Normal and tangential conditions of row k follow one another: 2 k and 2 k + 1 with friction, k without.
`rows` are `Rows` throughout.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import section
from contactlab_dynamics.row_updates import normal_update, tangential_update


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
def row_compliances(count, rows, compliance, local, nodes, dense):
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
def dense_sweeps(count, rows, dense, tolerance, limit):
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
                found, change = normal_update(k, gaps[j], rows)
                _move(dense[j], change, gaps)
                residual = max(residual, found)
            if not normal_only and rows.work[2, k] > 0.0:
                found, change = tangential_update(k, gaps[j + 1], rows)
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
