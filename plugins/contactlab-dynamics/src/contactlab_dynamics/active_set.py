"""Frictionless multipliers by active sets and conjugate gradients, in O(conditions) per pass.

Closed conditions take the forces that make their gaps zero, A y = -g with A = R C R^T; a condition changes
sides where y - g/a changes sign (primal-dual active set: Hintermueller, Ito & Kunisch 2003). From one step to
the next hardly any does, and A is as well conditioned as the compliances are alike, so that a dozen products
with A do (`chained_product`).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.enforcement import CHAINED
from contactlab_dynamics.chained_product import band_of, product, spread
from contactlab_dynamics.touched import number_nodes

SETS = 12  # active sets tried before the sweeps are asked; two or three are usual
BEYOND = 1e-2  # of the tolerance: how far a pass more or less may leave the gaps, so that forces are as good


@section
def _scales(count, start, local, weight, normal, soft, stiff, scale):
    """An estimate of every row's own compliance: its slave node's and the mean of its column's."""
    for i in range(count):
        nx, ny = normal[i, 0] * normal[i, 0], normal[i, 1] * normal[i, 1]
        total, sum_ = 0.0, 0.0
        for z in range(start[i], start[i + 1]):
            w = abs(weight[z])
            total += w * (nx * soft[local[z], 0] + ny * soft[local[z], 1])
            sum_ += w
        scale[i] = (total / sum_ if sum_ > 0.0 else 0.0) + stiff[i]


@section
def _worst(count, gaps, y, scale, size):
    """Largest natural residual min(g, a y) in segment lengths."""
    worst = 0.0
    for i in range(count):
        worst = max(worst, abs(min(gaps[i], scale[i] * y[i])) / size[i])
    return worst


@kernel
def solve_active(count, bound, compliance, multipliers, force, tolerance, limit):
    """Returns (passes, residual, largest correction); a residual above `tolerance` means that it gave up.

    `bound` are `ChainedRows`. If it gives up, `multipliers` and `force` are as they were.
    """
    start, node, weight, own, normal, gap, size, slot, above, below, inverse, gaps = unpack(bound, CHAINED)
    number = np.full(force.shape[0], -1, np.int32)
    touched = np.empty(start[count] + count, np.int32)
    columns = number_nodes(node[: start[count]], number, touched, 0)
    nodes = number_nodes(own[:count], number, touched, columns)
    local, mine = np.empty(start[count], np.int32), np.empty(count, np.int32)
    for z in range(start[count]):
        local[z] = number[node[z]]
    soft, nodal = np.empty((nodes, 2)), np.empty((nodes, 2))
    for n in range(nodes):
        soft[n, 0], soft[n, 1] = compliance[touched[n], 0], compliance[touched[n], 1]
    y, scale, stiff = np.empty(count), np.empty(count), np.empty(count)
    change, carried = np.empty(count), np.empty((2, count))
    alone = columns
    for i in range(count):
        mine[i] = number[own[i]] if own[i] >= 0 else -1
        if mine[i] >= 0:
            alone += 1
            nx, ny = normal[i, 0], normal[i, 1]
            stiff[i] = nx * nx * soft[mine[i], 0] + ny * ny * soft[mine[i], 1]
        else:
            stiff[i] = 0.0
    _scales(count, start, local, weight, normal, soft, stiff, scale)
    for i in range(count):
        y[i] = multipliers[0, slot[i]]
        if scale[i] == 0.0:
            return 0, np.inf, 0.0  # nothing there can give way: a matter for the sweeps
    # every own node counts once and in no column: nothing but the band joins conditions
    band = np.empty((0, 4, count))
    if alone == nodes:
        band = band_of(count, start, local, weight, soft, columns)
    passes, residual = _sets(
        count, start, local, weight, mine, normal, above, below, inverse, soft, band, stiff, gap, size, scale, y, gaps,
        change, carried, nodal, tolerance, limit,
    )  # fmt: skip
    if residual > tolerance:
        return passes, residual, 0.0
    spread(count, start, local, weight, mine, normal, above, below, inverse, y, carried, nodal)
    force[:] = 0.0
    multipliers[:] = 0.0
    largest = 0.0
    for n in range(nodes):
        force[touched[n], 0], force[touched[n], 1] = nodal[n, 0], nodal[n, 1]
        largest = max(largest, abs(soft[n, 0] * nodal[n, 0]), abs(soft[n, 1] * nodal[n, 1]))
    for i in range(count):
        multipliers[0, slot[i]] = y[i]
    return passes, residual, largest


@section
def _sets(
    count, start, local, weight, own, normal, above, below, inverse, soft, band, stiff, gap, size, scale, y, gaps,
    change, carried, nodal, tolerance, limit,
):  # fmt: skip
    """Active sets until no condition changes sides; y (k,) is the start and becomes the answer.

    Each turn of the loop is a product with forces `direction`: those of the start, those taken away from conditions
    that open, or a direction of the conjugate gradients on one set.
    """
    padded = np.zeros((2, count + band.shape[1]))
    residual, direction = np.empty(count), np.empty(count)
    easy, small = np.empty(count), np.empty(count)  # 1/scale, and 1/size
    active = np.empty(count, np.bool_)
    for i in range(count):
        easy[i], small[i] = 1.0 / scale[i], 1.0 / size[i]
        direction[i], gaps[i] = y[i], gap[i]
    passes, sets, goal = 0, 0, BEYOND * tolerance
    searching, dropped, before = False, False, 0.0
    while passes < limit:
        product(
            count, start, local, weight, own, normal, above, below, inverse, soft, band, stiff, direction, padded,
            carried, nodal, change,
        )  # fmt: skip
        passes += 1
        if searching:
            curvature = 0.0
            for i in range(count):
                curvature += direction[i] * change[i]
            if curvature > 0.0:
                length, after, largest = before / curvature, 0.0, 0.0
                for i in range(count):
                    y[i] += length * direction[i]
                    gaps[i] += length * change[i]
                    residual[i] = -gaps[i] if active[i] else 0.0
                for i in range(count):
                    after += residual[i] * (residual[i] * easy[i])
                    largest = max(largest, abs(residual[i]) * small[i])
                if largest > 0.5 * goal:
                    share, before = after / before, after
                    for i in range(count):
                        direction[i] = residual[i] * easy[i] + share * direction[i]
                    continue
        else:
            for i in range(count):
                gaps[i] += change[i]
        if not dropped:
            # forces that go on from the last steps are never taken unseen, however well they hold the gaps
            if sets == SETS or (sets > 0 and _worst(count, gaps, y, scale, size) <= goal):
                break
            sets += 1
            for i in range(count):
                active[i] = scale[i] * y[i] > gaps[i]
                direction[i] = 0.0
                if not active[i] and y[i] != 0.0:
                    direction[i], dropped = -y[i], True
                    y[i] = 0.0
            if dropped:  # forces of conditions that open are taken away at once
                searching = False
                continue
        before, dropped, searching = 0.0, False, True
        for i in range(count):
            residual[i] = -gaps[i] if active[i] else 0.0
            direction[i] = residual[i] * easy[i]
            before += residual[i] * direction[i]
        if not before > 0.0:
            break
    # a force that a dying condition keeps by round-off alone is no tension
    for i in range(count):
        if y[i] < 0.0 and -scale[i] * y[i] <= tolerance * size[i]:
            y[i] = 0.0
    return passes, _worst(count, gaps, y, scale, size)
