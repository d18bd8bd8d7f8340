"""Projected Gauss-Seidel on gap rows: normal conditions, then the friction clip, row by row.

While sweeping, `force` holds the corrections of the nodes, compliance times force, so that a row's
current gap costs one pass over its entries; at the end it is overwritten by the forces.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.kernel import kernel, section


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
    for z in range(begin, end):
        n = node[z]
        correction[n, 0] += compliance[n, 0] * weight[z, 0] * amount
        correction[n, 1] += compliance[n, 1] * weight[z, 1] * amount


@section
def _normal(k, begin, end, node, weight, gap, size, work, compliance, correction):
    """One normal update; returns the row's natural residual before it."""
    a = work[0, k]
    g = gap[k] + _row_value(begin, end, node, weight, correction)
    y = work[1, k]
    residual = abs(min(g, y * a)) / size[k]
    new = max(0.0, y - g / a)
    if new != y:
        work[1, k] = new
        _push(begin, end, node, weight, new - y, compliance, correction)
    return residual


@section
def _tangential(k, begin, end, node, weight, slip, size, measure, bound, work, compliance, correction):
    """One tangential update, clipped by the friction bound; returns the row's residual before it."""
    a = work[2, k]
    adhesion = bound[1, k] * measure[k]
    if bound[2, k] < np.inf:
        adhesion = min(adhesion, bound[2, k] * work[1, k])
    limit = bound[0, k] * work[1, k] + adhesion
    d = slip[k] + _row_value(begin, end, node, weight, correction)
    y = work[3, k]
    new = min(limit, max(-limit, y - d / a))
    if new != y:
        work[3, k] = new
        _push(begin, end, node, weight, new - y, compliance, correction)
    return abs(new - y) * a / size[k]


@section
def _prepare(count, start, node, normal, tangent, slot, work, compliance, multipliers, correction):
    """Row compliances, warm start, and the corrections that belong to it; returns rows without compliance."""
    rigid = 0
    friction = tangent.shape[0] > 0
    for k in range(count):
        begin, end = start[k], start[k + 1]
        work[0, k] = _row_compliance(begin, end, node, normal, compliance)
        work[1, k] = multipliers[0, slot[k]] if work[0, k] > 0.0 else 0.0
        if work[0, k] == 0.0:
            rigid += 1
        elif work[1, k] != 0.0:
            _push(begin, end, node, normal, work[1, k], compliance, correction)
        if friction:
            work[2, k] = _row_compliance(begin, end, node, tangent, compliance)
            work[3, k] = multipliers[1, slot[k]] if work[2, k] > 0.0 else 0.0
            if work[3, k] != 0.0:
                _push(begin, end, node, tangent, work[3, k], compliance, correction)
    return rigid


@section
def _finish(count, start, node, normal, tangent, slot, work, multipliers, force):
    """Multipliers to their slots and forces to the nodes; returns the largest correction found there."""
    largest = 0.0
    for k in range(count):
        for z in range(start[k], start[k + 1]):
            largest = max(largest, abs(force[node[z], 0]), abs(force[node[z], 1]))
    force[:] = 0.0
    multipliers[:] = 0.0
    for k in range(count):
        multipliers[0, slot[k]] = work[1, k]
        if tangent.shape[0] > 0:
            multipliers[1, slot[k]] = work[3, k]
        for z in range(start[k], start[k + 1]):
            for c in range(2):
                force[node[z], c] += normal[z, c] * work[1, k]
                if tangent.shape[0] > 0:
                    force[node[z], c] += tangent[z, c] * work[3, k]
    return largest


@kernel
def solve(
    count, start, node, normal, tangent, gap, slip, measure, size, slot, bound, work, compliance, multipliers,
    force, tolerance, limit,
):  # fmt: skip
    """Sweep over all rows in alternating directions; returns (sweeps, residual, rigid rows, largest correction)."""
    force[:] = 0.0
    rigid = _prepare(count, start, node, normal, tangent, slot, work, compliance, multipliers, force)
    sweeps, residual = 0, np.inf if count > rigid else 0.0
    while residual > tolerance and sweeps < limit:
        residual = 0.0
        for i in range(count):
            # alternating directions keep a symmetric scene symmetric
            k = i if sweeps % 2 == 0 else count - 1 - i
            begin, end = start[k], start[k + 1]
            if work[0, k] > 0.0:
                found = _normal(k, begin, end, node, normal, gap, size, work, compliance, force)
                residual = max(residual, found)
            if tangent.shape[0] > 0 and work[2, k] > 0.0:
                found = _tangential(k, begin, end, node, tangent, slip, size, measure, bound, work, compliance, force)
                residual = max(residual, found)
        sweeps += 1
    largest = _finish(count, start, node, normal, tangent, slot, work, multipliers, force)
    return sweeps, residual, rigid, largest
