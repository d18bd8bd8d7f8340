"""Frictionless multipliers by active sets and conjugate gradients, in O(conditions) per pass.

Closed conditions take the forces that make their gaps zero, A y = -g with A = R C R^T; a condition changes
sides where y - g/a changes sign (primal-dual active set: Hintermueller, Ito & Kunisch 2003). From one step to
the next hardly any does, and A is as well conditioned as the compliances are alike, so that a dozen products
with A do. R = T^-T [D^T | -M^T] is never formed: a product is a substitution with T, a pass over the columns, and
back.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.kernel import kernel, section
from contactlab_dynamics.touched import largest_correction, number_nodes

SETS = 12  # active sets tried before the sweeps are asked; two or three are usual
BEYOND = 1e-2  # of the tolerance: how far a pass more or less may leave the gaps, so that forces are as good


@kernel
def _spread(count, start, local, weight, own, normal, above, below, inverse, y, carried, nodal):
    """Nodal forces R^T y on the touched nodes, (L, 2)."""
    nodal[:] = 0.0
    for i in range(count):
        carried[i, 0], carried[i, 1] = y[i] * normal[i, 0], y[i] * normal[i, 1]
        if own[i] >= 0:
            nodal[own[i], 0] += carried[i, 0]
            nodal[own[i], 1] += carried[i, 1]
    for i in range(1, count):
        factor = below[i] * inverse[i - 1]
        carried[i, 0] -= factor * carried[i - 1, 0]
        carried[i, 1] -= factor * carried[i - 1, 1]
    carried[count - 1, 0] *= inverse[count - 1]
    carried[count - 1, 1] *= inverse[count - 1]
    for i in range(count - 2, -1, -1):
        carried[i, 0] = (carried[i, 0] - above[i + 1] * carried[i + 1, 0]) * inverse[i]
        carried[i, 1] = (carried[i, 1] - above[i + 1] * carried[i + 1, 1]) * inverse[i]
    for i in range(count):
        x, y_ = carried[i, 0], carried[i, 1]
        for z in range(start[i], start[i + 1]):
            nodal[local[z], 0] += weight[z] * x
            nodal[local[z], 1] += weight[z] * y_


@section
def _gather(count, start, local, weight, own, normal, above, below, inverse, moved, carried, out):
    """Changes of the gaps, R times the displacements `moved` (L, 2) of the touched nodes."""
    for i in range(count):
        x, y = 0.0, 0.0
        for z in range(start[i], start[i + 1]):
            x += weight[z] * moved[local[z], 0]
            y += weight[z] * moved[local[z], 1]
        carried[i, 0], carried[i, 1] = x, y
    carried[0, 0] *= inverse[0]
    carried[0, 1] *= inverse[0]
    for i in range(1, count):
        carried[i, 0] = (carried[i, 0] - above[i] * carried[i - 1, 0]) * inverse[i]
        carried[i, 1] = (carried[i, 1] - above[i] * carried[i - 1, 1]) * inverse[i]
    for i in range(count - 2, -1, -1):
        factor = below[i + 1] * inverse[i]
        carried[i, 0] -= factor * carried[i + 1, 0]
        carried[i, 1] -= factor * carried[i + 1, 1]
    for i in range(count):
        x, y = carried[i, 0], carried[i, 1]
        if own[i] >= 0:
            x += moved[own[i], 0]
            y += moved[own[i], 1]
        out[i] = normal[i, 0] * x + normal[i, 1] * y


@kernel
def _product(count, start, local, weight, own, normal, above, below, inverse, soft, y, carried, nodal, change):
    """Changes of the gaps by forces y (k,), A y."""
    _spread(count, start, local, weight, own, normal, above, below, inverse, y, carried, nodal)
    nodal *= soft
    _gather(count, start, local, weight, own, normal, above, below, inverse, nodal, carried, change)


@section
def _scales(count, start, local, weight, own, normal, compliance, scale):
    """An estimate of every row's own compliance: its slave node's and the mean of its column's."""
    for i in range(count):
        nx, ny = normal[i, 0] * normal[i, 0], normal[i, 1] * normal[i, 1]
        total, sum_ = 0.0, 0.0
        for z in range(start[i], start[i + 1]):
            w = abs(weight[z])
            total += w * (nx * compliance[local[z], 0] + ny * compliance[local[z], 1])
            sum_ += w
        scale[i] = total / sum_ if sum_ > 0.0 else 0.0
        if own[i] >= 0:
            scale[i] += nx * compliance[own[i], 0] + ny * compliance[own[i], 1]


@section
def _worst(count, gaps, y, scale, size):
    """Largest natural residual min(g, a y) in segment lengths."""
    worst = 0.0
    for i in range(count):
        worst = max(worst, abs(min(gaps[i], scale[i] * y[i])) / size[i])
    return worst


@kernel
def solve_active(
    count, start, node, weight, own, normal, gap, size, slot, above, below, inverse, compliance, multipliers, force,
    tolerance, limit,
):  # fmt: skip
    """Returns (passes, residual, largest correction); a residual above `tolerance` means that it gave up.

    `multipliers` and `force` are then as they were.
    """
    number = np.full(force.shape[0], -1, np.int32)
    touched = np.empty(start[count] + count, np.int32)
    nodes = number_nodes(node[: start[count]], number, touched, 0)
    nodes = number_nodes(own[:count], number, touched, nodes)
    local, mine = np.empty(start[count], np.int32), np.empty(count, np.int32)
    for z in range(start[count]):
        local[z] = number[node[z]]
    soft = np.empty((nodes, 2))
    for n in range(nodes):
        soft[n, 0], soft[n, 1] = compliance[touched[n], 0], compliance[touched[n], 1]
    for i in range(count):
        mine[i] = number[own[i]] if own[i] >= 0 else -1
    y, gaps, scale, change = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    carried, nodal = np.empty((count, 2)), np.empty((nodes, 2))
    _scales(count, start, local, weight, mine, normal, soft, scale)
    for i in range(count):
        y[i] = multipliers[0, slot[i]]
        if scale[i] == 0.0:
            return 0, np.inf, 0.0  # nothing there can give way: a matter for the sweeps
    passes, residual = _sets(
        count, start, local, weight, mine, normal, above, below, inverse, gap, size, scale, soft, y, gaps, change,
        carried, nodal, tolerance, limit,
    )  # fmt: skip
    if residual > tolerance:
        return passes, residual, 0.0
    _spread(count, start, local, weight, mine, normal, above, below, inverse, y, carried, nodal)
    force[:] = 0.0
    multipliers[:] = 0.0
    for n in range(nodes):
        force[touched[n], 0], force[touched[n], 1] = nodal[n, 0], nodal[n, 1]
    for i in range(count):
        multipliers[0, slot[i]] = y[i]
    return passes, residual, largest_correction(touched[:nodes], compliance, force)


@section
def _sets(
    count, start, local, weight, own, normal, above, below, inverse, gap, size, scale, soft, y, gaps, change, carried,
    nodal, tolerance, limit,
):  # fmt: skip
    """Active sets until no condition changes sides; y (k,) is the start and becomes the answer."""
    residual, direction = np.empty(count), np.empty(count)
    active = np.empty(count, np.bool_)
    _product(count, start, local, weight, own, normal, above, below, inverse, soft, y, carried, nodal, change)
    for i in range(count):
        gaps[i] = gap[i] + change[i]
    passes = 1
    goal = BEYOND * tolerance
    for number in range(SETS):
        # forces that go on from the last steps are never taken unseen, however well they hold the gaps
        if (number > 0 and _worst(count, gaps, y, scale, size) <= goal) or passes >= limit:
            break
        # forces of conditions that open are taken away at once
        dropped = False
        for i in range(count):
            active[i] = scale[i] * y[i] > gaps[i]
            direction[i] = 0.0
            if not active[i] and y[i] != 0.0:
                direction[i], dropped = -y[i], True
                y[i] = 0.0
        if dropped:
            _product(
                count, start, local, weight, own, normal, above, below, inverse, soft, direction, carried, nodal, change
            )
            passes += 1
            for i in range(count):
                gaps[i] += change[i]
        before = 0.0
        for i in range(count):
            residual[i] = -gaps[i] if active[i] else 0.0
            direction[i] = residual[i] / scale[i]
            before += residual[i] * direction[i]
        while before > 0.0 and passes < limit:
            _product(
                count, start, local, weight, own, normal, above, below, inverse, soft, direction, carried, nodal, change
            )
            passes += 1
            curvature = 0.0
            for i in range(count):
                curvature += direction[i] * change[i]
            if not curvature > 0.0:
                break
            length = before / curvature
            after, largest = 0.0, 0.0
            for i in range(count):
                y[i] += length * direction[i]
                gaps[i] += length * change[i]
                if active[i]:
                    residual[i] = -gaps[i]
                    after += residual[i] * residual[i] / scale[i]
                    largest = max(largest, abs(gaps[i]) / size[i])
            if largest <= 0.5 * goal:
                break
            for i in range(count):
                direction[i] = residual[i] / scale[i] + after / before * direction[i]
            before = after
    # a force that a dying condition keeps by round-off alone is no tension
    for i in range(count):
        if y[i] < 0.0 and -scale[i] * y[i] <= tolerance * size[i]:
            y[i] = 0.0
    return passes, _worst(count, gaps, y, scale, size)
