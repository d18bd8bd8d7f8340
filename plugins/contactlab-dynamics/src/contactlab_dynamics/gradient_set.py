"""Frictionless multipliers by active sets and conjugate gradients, in O(conditions) per pass.

Closed conditions take the forces that make their gaps zero, A y = -g with A = G C G^T; a condition changes
sides where y - g/a changes sign (primal-dual active set: Hintermueller, Ito & Kunisch 2003). From one step to
the next hardly any does, and A is as well conditioned as the compliances are alike, so that a dozen products
with A do. Here rows are the derivatives of their gaps (`FactoredGradients`), and products go through the nodes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import Flags, Floats
from contactlab.api.compiled.gradient_products import conditions_moved, nodes_pushed
from contactlab.api.compiled.kernel import kernel, section

SETS = 12  # active sets tried before the sweeps take over; two or three are usual
BEYOND = 0.3  # of the tolerance: forces need not be better than the work that is left, 1e-10 segments of way


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
def _scales(rows, soft, scale):
    """An estimate of every row's own compliance: its slave node's and the mean of its column's."""
    f = rows.factors
    for i in range(scale.size):
        nx, ny = f.normal[i, 0] * f.normal[i, 0], f.normal[i, 1] * f.normal[i, 1]
        total, sum_ = 0.0, 0.0
        for z in range(f.start[i], f.start[i + 1]):
            n, w = f.node[z], abs(rows.block[z, 0, 0] + rows.block[z, 1, 1])
            total += w * (nx * soft[n, 0] + ny * soft[n, 1])
            sum_ += w
        scale[i] = total / sum_ if sum_ > 0.0 else 0.0
        if f.own[i] >= 0:
            scale[i] += nx * soft[f.own[i], 0] + ny * soft[f.own[i], 1]


@kernel
def solve_gradients(count, rows, compliance, multipliers, force, tolerance, limit):
    """Returns (passes, residual, largest correction); a residual above `tolerance` means that it gave up.

    `rows` are `FactoredGradients`, the first `count` of them in use. If it gives up, `multipliers` and `force` are as
    they were.
    """
    size = rows.used[0]
    soft, nodal, moment, carried = (
        np.empty((size, 2)),
        np.empty((size, 2)),
        np.empty(rows.used[1]),
        np.empty((2, count)),
    )
    for n in range(size):
        node = rows.nodes[n]
        soft[n, 0], soft[n, 1] = compliance[node, 0], compliance[node, 1]
    y, scale = np.empty(count), np.empty(count)
    _scales(rows, soft, scale)
    for i in range(count):
        y[i] = multipliers[0, rows.factors.slot[i]]
        if scale[i] == 0.0:
            return 0, np.inf, 0.0  # nothing there can move: left to the sweeps
    passes, residual = _sets(rows, soft, y, scale, (nodal, moment, carried), tolerance, limit)
    if residual > tolerance:
        return passes, residual, 0.0
    nodes_pushed(rows, y, nodal, moment, carried)
    force[:] = 0.0
    multipliers[:] = 0.0
    largest = 0.0
    for n in range(size):
        node = rows.nodes[n]
        force[node, 0], force[node, 1] = nodal[n, 0], nodal[n, 1]
        largest = max(largest, abs(soft[n, 0] * nodal[n, 0]), abs(soft[n, 1] * nodal[n, 1]))
    for i in range(count):
        multipliers[0, rows.factors.slot[i]] = y[i]
        rows.factors.left[i] += rows.offset[i]
    return passes, residual, largest


@section
def _product(rows, soft, y, scratch, out):
    """Changes of the gaps (k,) by forces y (k,)."""
    nodal, moment, carried = scratch
    nodes_pushed(rows, y, nodal, moment, carried)
    for n in range(soft.shape[0]):
        nodal[n, 0], nodal[n, 1] = soft[n, 0] * nodal[n, 0], soft[n, 1] * nodal[n, 1]
    conditions_moved(rows, y.size, nodal, moment, carried, out)


@section
def _sets(rows, soft, y, scale, scratch, tolerance, limit):
    """Active sets until no condition changes sides; y (k,) is the start and becomes the answer."""
    count, gaps, size = y.size, rows.factors.left, rows.factors.size
    search = Search(
        np.empty(count, np.bool_), np.empty(count), np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    )
    for i in range(count):
        search.easy[i], search.small[i] = 1.0 / scale[i], 1.0 / size[i]
        search.direction[i], gaps[i] = y[i], rows.factors.gap[i]
    passes, sets, goal, searching, before = 0, 0, BEYOND * tolerance, False, 0.0
    while passes < limit:
        _product(rows, soft, search.direction, scratch, search.change)
        passes += 1
        if searching:
            before, onwards = descend(y, gaps, search, before, goal)
            if onwards:
                continue
        else:
            for i in range(count):
                gaps[i] += search.change[i]
        if sets == SETS or (sets > 0 and worst_residual(gaps, y, scale, size) <= goal):
            break
        sets += 1
        searching = not choose(y, gaps, scale, search)
        if not searching:  # forces of all conditions that open are taken away together
            continue
        before = begin_descent(gaps, search)
        if not before > 0.0:
            break
    drop_round_off(y, scale, size, tolerance)
    return passes, worst_residual(gaps, y, scale, size)


@section
def worst_residual(gaps, y, scale, size):
    """Largest natural residual min(g, a y) in segment lengths."""
    worst = 0.0
    for i in range(y.size):
        worst = max(worst, abs(min(gaps[i], scale[i] * y[i])) / size[i])
    return worst


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
