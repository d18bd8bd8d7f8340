"""Projected Gauss-Seidel on the entries of the rows.

While sweeping, `correction` (N, 2) [mm] is compliance times force, so that a row's current gap costs one
pass over its entries. `rows` are `Rows` throughout.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import section
from contactlab_dynamics.row_updates import normal_update, tangential_update


@section
def row_diagonals(count, rows, compliance):
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
def _warm(count, rows, compliance, correction):
    """Corrections that belong to the forces of the warm start."""
    correction[:] = 0.0
    for k in range(count):
        begin, end = rows.start[k], rows.start[k + 1]
        _push(begin, end, rows.node, rows.normal_weight, rows.work[1, k], compliance, correction)
        if rows.tangent_weight.shape[0] > 0:
            _push(begin, end, rows.node, rows.tangent_weight, rows.work[3, k], compliance, correction)


@section
def sparse_sweeps(count, rows, compliance, correction, tolerance, limit):
    """Sweep until the residual falls below `tolerance`; returns (sweeps, residual)."""
    _warm(count, rows, compliance, correction)
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
                found, change = normal_update(k, present, rows)
                _push(begin, end, node, normal, change, compliance, correction)
                residual = max(residual, found)
            if tangent.shape[0] > 0 and rows.work[2, k] > 0.0:
                present = rows.slip[k] + _row_value(begin, end, node, tangent, correction)
                found, change = tangential_update(k, present, rows)
                _push(begin, end, node, tangent, change, compliance, correction)
                residual = max(residual, found)
        sweeps += 1
    return sweeps, residual
