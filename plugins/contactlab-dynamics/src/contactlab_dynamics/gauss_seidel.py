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
def _warm_start(count, slot, tangent, work, multipliers):
    """Forces to start from; returns the number of rows without compliance."""
    rigid = 0
    for k in range(count):
        work[1, k] = multipliers[0, slot[k]] if work[0, k] > 0.0 else 0.0
        rigid += work[0, k] == 0.0
        if tangent.shape[0] > 0:
            work[3, k] = multipliers[1, slot[k]] if work[2, k] > 0.0 else 0.0
    return rigid


@section
def _add_force(begin, end, node, weight, amount, force):
    if amount != 0.0:
        for z in range(begin, end):
            force[node[z], 0] += weight[z, 0] * amount
            force[node[z], 1] += weight[z, 1] * amount


@section
def _finish(count, start, node, normal, tangent, slot, work, multipliers, force):
    """Multipliers to their slots and forces to the nodes."""
    force[:] = 0.0
    multipliers[:] = 0.0
    for k in range(count):
        multipliers[0, slot[k]] = work[1, k]
        _add_force(start[k], start[k + 1], node, normal, work[1, k], force)
        if tangent.shape[0] > 0:
            multipliers[1, slot[k]] = work[3, k]
            _add_force(start[k], start[k + 1], node, tangent, work[3, k], force)


@kernel
def solve_dense(
    count, start, node, normal, tangent, gap, slip, measure, size, slot, bound, work, compliance, multipliers,
    force, tolerance, limit,
):  # fmt: skip
    """Sweep over all rows in alternating directions; returns (sweeps, residual, rigid rows, largest correction)."""
    frictionless = tangent.shape[0] == 0
    local = np.full(force.shape[0], -1, np.int32)
    touched = np.empty(force.shape[0], np.int32)
    nodes = number_nodes(node[: start[count]], local, touched, 0)
    conditions = count if frictionless else 2 * count
    dense = np.zeros((conditions, conditions))
    row_compliances(count, start, node, normal, tangent, compliance, local, nodes, dense, work)
    rigid = _warm_start(count, slot, tangent, work, multipliers)
    sweeps, residual = 0, 0.0
    if count > rigid:
        sweeps, residual = dense_sweeps(
            count, frictionless, gap, slip, measure, size, bound, work, dense, tolerance, limit
        )
    _finish(count, start, node, normal, tangent, slot, work, multipliers, force)
    return sweeps, residual, rigid, largest_correction(touched[:nodes], compliance, force)


@kernel
def solve_sparse(
    count, start, node, normal, tangent, gap, slip, measure, size, slot, bound, work, compliance, multipliers,
    force, tolerance, limit,
):  # fmt: skip
    """As `solve_dense`, without its matrix."""
    row_diagonals(count, start, node, normal, tangent, compliance, work)
    rigid = _warm_start(count, slot, tangent, work, multipliers)
    sweeps, residual = 0, 0.0
    if count > rigid:
        sweeps, residual = sparse_sweeps(
            count, start, node, normal, tangent, gap, slip, measure, size, bound, work, compliance, force, tolerance,
            limit,
        )  # fmt: skip
    _finish(count, start, node, normal, tangent, slot, work, multipliers, force)
    return sweeps, residual, rigid, largest_correction(node[: start[count]], compliance, force)
