"""Projected Gauss-Seidel on gap rows: normal conditions, then the friction clip, row by row.

The rows of a few dozen conditions share most of their nodes: forming their dense compliance once is then
cheaper than a second sweep over their entries (`dense_sweep`). Many rows are swept as they are (`sparse_sweep`).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab_dynamics.dense_sweep import dense_sweeps, row_compliances
from contactlab_dynamics.sparse_sweep import row_diagonals, sparse_sweeps
from contactlab_dynamics.touched import largest_correction, number_nodes


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
    row_compliances(count, rows, compliance, local, nodes, dense)
    rigid = _warm_start(count, rows, multipliers)
    sweeps, residual = 0, 0.0
    if count > rigid:
        sweeps, residual = dense_sweeps(count, rows, dense, tolerance, limit)
    _finish(count, rows, multipliers, force)
    return sweeps, residual, rigid, largest_correction(touched[:nodes], compliance, force)


@kernel
def solve_sparse(count, rows, compliance, multipliers, force, tolerance, limit):
    """Solve as `solve_dense` does, without a dense matrix."""
    row_diagonals(count, rows, compliance)
    rigid = _warm_start(count, rows, multipliers)
    sweeps, residual = 0, 0.0
    if count > rigid:
        sweeps, residual = sparse_sweeps(count, rows, compliance, force, tolerance, limit)
    _finish(count, rows, multipliers, force)
    return sweeps, residual, rigid, largest_correction(rows.node[: rows.start[count]], compliance, force)
