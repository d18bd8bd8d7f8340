"""Frictionless multipliers by active sets and conjugate gradients, in O(constraints) per iteration.

Closed constraints take the forces that make their gaps zero, A y = -g with A = G C G^T; a constraint changes sides
where y - g/a changes sign (primal-dual active set: Hintermueller, Ito & Kunisch 2003). From one step to the next hardly
any does, and A is as well conditioned as the compliances are alike, so that a dozen products with A do.

Both forms of rows share the solver: `FactoredRows`, whose products use a band of A if rows share nodes with their
neighbours alone (`factored_product`), and `FactoredGradients`, whose products go through the nodes. `product(held, y,
out)` gives the changes of the gaps (k,) by forces y (k,), and `nodal_forces(held, y)` leaves G^T y in `held.nodal`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import Flags, Floats
from contactlab.api.compiled.gradient_products import conditions_moved, nodes_pushed
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.enforcement import FactoredGradients
from contactlab_dynamics.factored_product import held_columns, product_of_columns, push_columns

SETS = 12  # active sets tried before the sweeps take over; two or three are usual
BEYOND_GRADIENTS = 0.3  # of the tolerance: forces need not be better than the work that is left, 1e-10 segments of way
BEYOND_NORMALS = 1e-2  # of the tolerance: with an iteration more or less in leaving gaps, forces are as good


class Search(NamedTuple):
    """Direction of conjugate gradients and what goes with it, (k,) each.

    active     constraints that are closed
    direction  forces whose effect on the gaps is computed next, `change` their effect
    residual   gaps of the active constraints, with the other sign
    easy       [N/mm] one over the compliance of each row, roughly
    small      [1/mm] one over the length of the segments
    """

    active: Flags
    direction: Floats
    change: Floats
    residual: Floats
    easy: Floats
    small: Floats


class Gradients(NamedTuple):
    """`FactoredGradients`, the compliances soft (L, 2) of their nodes, and scratch arrays of products."""

    rows: FactoredGradients
    soft: Floats
    nodal: Floats
    moment: Floats
    carried: Floats


@kernel
def solve_active(count, rows, compliance, multipliers, force, tolerance, limit):
    """Solve for forces along normals. Returns (passes, residual, largest correction).

    `rows` are `FactoredRows`, the first `count` of them in use. If the residual is above `tolerance`, it gave up, and
    `multipliers` and `force` are as they were.
    """
    held, nodes, scale = held_columns(count, rows, compliance)
    return _solve(
        held, product_of_columns, push_columns, rows, nodes, scale, compliance, multipliers, force,
        (tolerance, BEYOND_NORMALS * tolerance), limit, True,
    )  # fmt: skip


@kernel
def solve_gradients(count, rows, compliance, multipliers, force, tolerance, limit):
    """Solve for forces along gradients, as `solve_active`; `rows` are `FactoredGradients`."""
    f, nodes, scale = rows.factors, rows.nodes[: rows.used[0]], np.empty(count)
    soft = np.empty((nodes.size, 2))
    for n in range(nodes.size):
        soft[n, 0], soft[n, 1] = compliance[nodes[n], 0], compliance[nodes[n], 1]
    for i in range(count):
        # an estimate of the row's own compliance: its slave node's and the mean of its column's
        nx, ny = f.normal[i, 0] * f.normal[i, 0], f.normal[i, 1] * f.normal[i, 1]
        total, sum_ = 0.0, 0.0
        for z in range(f.start[i], f.start[i + 1]):
            n, w = f.node[z], abs(rows.block[z, 0, 0] + rows.block[z, 1, 1])
            total += w * (nx * soft[n, 0] + ny * soft[n, 1])
            sum_ += w
        scale[i] = total / sum_ if sum_ > 0.0 else 0.0
        if f.own[i] >= 0:
            scale[i] += nx * soft[f.own[i], 0] + ny * soft[f.own[i], 1]
    held = Gradients(rows, soft, np.empty((nodes.size, 2)), np.empty(rows.used[1]), np.empty((2, count)))
    passes, residual, largest = _solve(
        held, _product, _nodal_forces, f, nodes, scale, compliance, multipliers, force,
        (tolerance, BEYOND_GRADIENTS * tolerance), limit, False,
    )  # fmt: skip
    if residual <= tolerance:
        for i in range(count):
            f.left[i] += rows.offset[i]
    return passes, residual, largest


@section
def _nodal_forces(held, y):
    nodes_pushed(held.rows, y, held.nodal, held.moment, held.carried)


@section
def _product(held, y, out):
    nodal, soft = held.nodal, held.soft
    nodes_pushed(held.rows, y, nodal, held.moment, held.carried)
    for n in range(soft.shape[0]):
        nodal[n, 0], nodal[n, 1] = soft[n, 0] * nodal[n, 0], soft[n, 1] * nodal[n, 1]
    conditions_moved(held.rows, y.size, nodal, held.moment, held.carried, out)


@section
def _solve(held, product, nodal_forces, factors, nodes, scale, compliance, multipliers, force, goals, limit, keep):
    """Solve for rows of either form: `factors` are their `FactoredRows`, `nodes` (L,) the global nodes."""
    y, tolerance = np.empty(scale.size), goals[0]
    for i in range(y.size):
        y[i] = multipliers[0, factors.slot[i]]
        if scale[i] == 0.0:
            return 0, np.inf, 0.0  # nothing there can move: left to the sweeps
    passes, residual = _sets(held, product, factors, y, scale, goals, limit, keep)
    if residual > tolerance:
        return passes, residual, 0.0
    nodal_forces(held, y)
    force[:] = 0.0
    multipliers[:] = 0.0
    largest, nodal = 0.0, held.nodal
    for n in range(nodes.size):
        x, y_ = nodal[n, 0], nodal[n, 1]
        force[nodes[n], 0], force[nodes[n], 1] = x, y_
        largest = max(largest, abs(compliance[nodes[n], 0] * x), abs(compliance[nodes[n], 1] * y_))
    for i in range(y.size):
        multipliers[0, factors.slot[i]] = y[i]
    return passes, residual, largest


@section
def _sets(held, product, factors, y, scale, goals, limit, keep):
    """Change active sets until no constraint changes sides; y (k,) is the start and becomes the answer.

    Each turn of the loop is a product with forces `direction`: forces of the start, forces taken away from constraints
    that open, or a direction of the conjugate gradients on one set. factors.left receives the gaps. `keep` the set
    from which forces were taken away; otherwise it is chosen again by the gaps that follow.
    """
    count, gaps, size, (tolerance, goal) = y.size, factors.left, factors.size, goals
    search = Search(
        np.empty(count, np.bool_), np.empty(count), np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    )
    for i in range(count):
        search.easy[i], search.small[i] = 1.0 / scale[i], 1.0 / size[i]
        search.direction[i], gaps[i] = y[i], factors.gap[i]
    passes, sets, searching, kept, before = 0, 0, False, False, 0.0
    while passes < limit:
        product(held, search.direction, search.change)
        passes += 1
        if searching:
            before, onwards = _descend(y, gaps, search, before, goal)
            if onwards:
                continue
        else:
            for i in range(count):
                gaps[i] += search.change[i]
        if not kept:
            # forces that go on from the last steps are never taken unseen, however well they hold the gaps
            if sets == SETS or (sets > 0 and _worst_residual(gaps, y, scale, size) <= goal):
                break
            sets += 1
            if _choose(y, gaps, scale, search):  # forces of all constraints that open are taken away together
                searching, kept = False, keep
                continue
        before, searching, kept = _begin_descent(gaps, search), True, False
        if not before > 0.0:
            break
    for i in range(count):
        # a force that a constraint about to open keeps by round-off alone is not tension
        if y[i] < 0.0 and -scale[i] * y[i] <= tolerance * size[i]:
            y[i] = 0.0
    return passes, _worst_residual(gaps, y, scale, size)


@section
def _worst_residual(gaps, y, scale, size):
    """Return the largest natural residual min(g, a y) in segment lengths."""
    worst = 0.0
    for i in range(y.size):
        worst = max(worst, abs(min(gaps[i], scale[i] * y[i])) / size[i])
    return worst


@section
def _choose(y, gaps, scale, search):
    """Choose the active set by these forces and gaps. Return whether constraints leave it: then take `direction`."""
    dropped = False
    for i in range(y.size):
        search.active[i] = scale[i] * y[i] > gaps[i]
        search.direction[i] = 0.0
        if not search.active[i] and y[i] != 0.0:
            search.direction[i], dropped = -y[i], True
            y[i] = 0.0
    return dropped


@section
def _begin_descent(gaps, search):
    """Begin conjugate gradients on a set. Return the scaled square of the residual.

    `gaps` may have room for more constraints than the (k,) arrays of `search`.
    """
    square = 0.0
    for i in range(search.residual.size):
        search.residual[i] = -gaps[i] if search.active[i] else 0.0
        search.direction[i] = search.residual[i] * search.easy[i]
        square += search.residual[i] * search.direction[i]
    return square


@section
def _descend(y, gaps, search, before, goal):
    """Make a step of the conjugate gradients. Return the scaled square of the residual, and whether to continue."""
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
