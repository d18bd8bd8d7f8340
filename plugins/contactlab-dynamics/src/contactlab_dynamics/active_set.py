"""Frictionless multipliers by active sets and conjugate gradients, for rows along normals (`FactoredRows`).

As `gradient_set`, with products by the band of A if rows share nodes with their neighbours alone (`factored_product`).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab_dynamics.factored_product import Compliances, Scratch, Touched, band_of, product, spread
from contactlab_dynamics.gradient_set import (
    SETS,
    Search,
    begin_descent,
    choose,
    descend,
    drop_round_off,
    worst_residual,
)
from contactlab_dynamics.touched import number_nodes

BEYOND = 1e-2  # of the tolerance: how far a pass more or less may leave the gaps, so that forces are as good


@section
def _scales(rows, touched, soft, stiff, scale):
    """An estimate of every row's own compliance: its slave node's and the mean of its column's."""
    for i in range(scale.size):
        nx, ny = rows.normal[i, 0] * rows.normal[i, 0], rows.normal[i, 1] * rows.normal[i, 1]
        total, sum_ = 0.0, 0.0
        for z in range(rows.start[i], rows.start[i + 1]):
            w = abs(rows.weight[z])
            total += w * (nx * soft[touched.local[z], 0] + ny * soft[touched.local[z], 1])
            sum_ += w
        scale[i] = (total / sum_ if sum_ > 0.0 else 0.0) + stiff[i]


@section
def _number(count, rows, number, found):
    """List the nodes that the first `count` rows touch in `found`, numbered in `number` (N,).

    Returns `Touched`, how many nodes there are, how many of them are in columns, and how often own nodes count.
    """
    entries = rows.start[count]
    columns = number_nodes(rows.node[:entries], number, found, 0)
    nodes = number_nodes(rows.own[:count], number, found, columns)
    local, row, own, once = np.empty(entries, np.int32), np.zeros(entries + 1, np.int32), np.empty(count, np.int32), 0
    for z in range(entries):
        local[z] = number[rows.node[z]]
    # every entry with its row: no processor predicts the end of loops over the few entries of a row
    for i in range(1, count):
        row[rows.start[i]] += 1
    for z in range(1, entries):
        row[z] += row[z - 1]
    for i in range(count):
        own[i] = number[rows.own[i]] if rows.own[i] >= 0 else -1
        once += own[i] >= 0
    return Touched(local, row[:entries], own), nodes, columns, once


@kernel
def solve_active(count, rows, compliance, multipliers, force, tolerance, limit):
    """Returns (passes, residual, largest correction); a residual above `tolerance` means that it gave up.

    `rows` are `FactoredRows`, the first `count` of them in use. If it gives up, `multipliers` and `force` are as
    they were.
    """
    number, found = np.full(force.shape[0], -1, np.int32), np.empty(rows.start[count] + count, np.int32)
    touched, nodes, columns, once = _number(count, rows, number, found)
    soft, nodal = np.empty((nodes, 2)), np.empty((nodes, 2))
    for n in range(nodes):
        soft[n, 0], soft[n, 1] = compliance[found[n], 0], compliance[found[n], 1]
    y, scale, stiff = np.empty(count), np.empty(count), np.zeros(count)
    for i in range(count):
        n = touched.own[i]
        if n >= 0:
            nx, ny = rows.normal[i, 0], rows.normal[i, 1]
            stiff[i] = nx * nx * soft[n, 0] + ny * ny * soft[n, 1]
    _scales(rows, touched, soft, stiff, scale)
    for i in range(count):
        y[i] = multipliers[0, rows.slot[i]]
        if scale[i] == 0.0:
            return 0, np.inf, 0.0  # nothing there can move: left to the sweeps
    # every own node counts once and in no column: nothing but the band joins conditions
    band = np.empty((0, 4, count))
    if columns + once == nodes:
        band = band_of(rows, touched, soft, columns)
    scratch = Scratch(np.zeros((2, count + band.shape[1])), np.empty((2, count)), nodal)
    passes, residual = _sets(rows, touched, Compliances(soft, band, stiff, scale), y, scratch, tolerance, limit)
    if residual > tolerance:
        return passes, residual, 0.0
    spread(rows, touched, y, scratch.carried, nodal)
    force[:] = 0.0
    multipliers[:] = 0.0
    largest = 0.0
    for n in range(nodes):
        force[found[n], 0], force[found[n], 1] = nodal[n, 0], nodal[n, 1]
        largest = max(largest, abs(soft[n, 0] * nodal[n, 0]), abs(soft[n, 1] * nodal[n, 1]))
    for i in range(count):
        multipliers[0, rows.slot[i]] = y[i]
    return passes, residual, largest


@section
def _sets(rows, touched, compliances, y, scratch, tolerance, limit):
    """Active sets until no condition changes sides; y (k,) is the start and becomes the answer.

    Each turn of the loop is a product with forces `direction`: forces of the start, forces taken away from conditions
    that open, or a direction of the conjugate gradients on one set. rows.left receives the gaps.
    """
    count, gaps, scale, size = y.size, rows.left, compliances.scale, rows.size
    search = Search(
        np.empty(count, np.bool_), np.empty(count), np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    )
    for i in range(count):
        search.easy[i], search.small[i] = 1.0 / scale[i], 1.0 / size[i]
        search.direction[i], gaps[i] = y[i], rows.gap[i]
    passes, sets, goal = 0, 0, BEYOND * tolerance
    searching, dropped, before = False, False, 0.0
    while passes < limit:
        product(rows, touched, compliances, search.direction, scratch, search.change)
        passes += 1
        if searching:
            before, onwards = descend(y, gaps, search, before, goal)
            if onwards:
                continue
        else:
            for i in range(count):
                gaps[i] += search.change[i]
        if not dropped:
            # forces that go on from the last steps are never taken unseen, however well they hold the gaps
            if sets == SETS or (sets > 0 and worst_residual(gaps, y, scale, size) <= goal):
                break
            sets += 1
            dropped = choose(y, gaps, scale, search)
            if dropped:  # forces of all conditions that open are taken away together
                searching = False
                continue
        before, dropped, searching = begin_descent(gaps, search), False, True
        if not before > 0.0:
            break
    drop_round_off(y, scale, size, tolerance)
    return passes, worst_residual(gaps, y, scale, size)
