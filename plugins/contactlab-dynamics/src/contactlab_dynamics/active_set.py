"""Frictionless multipliers by active sets and conjugate gradients, in O(conditions) per pass.

Closed conditions take the forces that make their gaps zero, A y = -g with A = R C R^T; a condition changes
sides where y - g/a changes sign (primal-dual active set: Hintermueller, Ito & Kunisch 2003). From one step to
the next hardly any does, and A is as well conditioned as the compliances are alike, so that a dozen products
with A do (`factored_product`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import Flags, Floats
from contactlab.api.compiled.kernel import kernel, section
from contactlab_dynamics.factored_product import Compliances, Scratch, Touched, band_of, product, spread
from contactlab_dynamics.touched import number_nodes

SETS = 12  # active sets tried before the sweeps take over; two or three are usual
BEYOND = 1e-2  # of the tolerance: how far a pass more or less may leave the gaps, so that forces are as good


class Search(NamedTuple):
    """Direction of conjugate gradients and what goes with it, (k,) each.

    active     conditions that are closed
    direction  forces whose effect on the gaps is computed next, `change` their effect
    residual   gaps of the active conditions, with the other sign
    easy       [N/mm] one over the compliance of each row, roughly
    small      [1/mm] one over the length of the segments
    """

    active: Flags
    direction: Floats
    change: Floats
    residual: Floats
    easy: Floats
    small: Floats


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
def worst_residual(gaps, y, scale, size):
    """Largest natural residual min(g, a y) in segment lengths."""
    worst = 0.0
    for i in range(y.size):
        worst = max(worst, abs(min(gaps[i], scale[i] * y[i])) / size[i])
    return worst


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


@section
def choose(y, gaps, scale, search):
    """The active set of these forces and gaps; whether conditions leave it, whose forces are `direction` then."""
    dropped = False
    for i in range(y.size):
        search.active[i] = scale[i] * y[i] > gaps[i]
        search.direction[i] = 0.0
        if not search.active[i] and y[i] != 0.0:
            search.direction[i], dropped = -y[i], True
            y[i] = 0.0
    return dropped


@section
def begin_descent(gaps, search):
    """The first direction of the conjugate gradients on a set; returns the scaled square of the residual.

    `gaps` may have room for more conditions than the (k,) arrays of `search`.
    """
    square = 0.0
    for i in range(search.residual.size):
        search.residual[i] = -gaps[i] if search.active[i] else 0.0
        search.direction[i] = search.residual[i] * search.easy[i]
        square += search.residual[i] * search.direction[i]
    return square


@section
def drop_round_off(y, scale, size, tolerance):
    """A force that a condition about to open keeps by round-off alone is not tension: it is set to zero."""
    for i in range(y.size):
        if y[i] < 0.0 and -scale[i] * y[i] <= tolerance * size[i]:
            y[i] = 0.0


@section
def descend(y, gaps, search, before, goal):
    """Make a step of the conjugate gradients; returns the scaled square of the residual and whether to go on."""
    direction, change, residual = search.direction, search.change, search.residual
    curvature = 0.0
    for i in range(y.size):
        curvature += direction[i] * change[i]
    if not curvature > 0.0:
        return before, False
    length, after, largest = before / curvature, 0.0, 0.0
    for i in range(y.size):
        y[i] += length * direction[i]
        gaps[i] += length * change[i]
        residual[i] = -gaps[i] if search.active[i] else 0.0
    for i in range(y.size):
        after += residual[i] * (residual[i] * search.easy[i])
        largest = max(largest, abs(residual[i]) * search.small[i])
    if not largest > 0.5 * goal:
        return before, False
    share = after / before
    for i in range(y.size):
        direction[i] = residual[i] * search.easy[i] + share * direction[i]
    return after, True
