"""Moments of smooth surfaces: integrals of the multipliers' basis times the cubics between curves and segments.

See `contactlab.kernels.contact.smooth`; edges have two nodes.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.formulas.segment_derivatives import (
    MOST_NODES,
    NUMBERS,
    collect,
    find,
    put_change,
    put_sum,
    quantities,
    shares_of,
)
from contactlab.formulas.segment_kernels import (
    BASIS,
    CUBIC_POINTS,
    CUBIC_WEIGHTS,
    PARAMETERS,
    PARTS,
    cut,
    facing,
    master_segment,
    slave_segment,
)
from contactlab.formulas.segment_normals import Both
from contactlab.kernels.contact.smooth import hermite


@section
def put_moments(ends, p, length, low, high, fields, out):
    """Compute moments (4, 2) of piece p of a slave segment of this weighted length, with overlap `low` to `high`."""
    first, eta_first, last, eta_last = ends[p, 0], ends[p, 1], ends[p, 2], ends[p, 3]
    slope = (eta_last - eta_first) / (last - first)
    for row in range(4):
        out[p, row, 0], out[p, row, 1] = 0.0, 0.0
    for part in range(PARTS):
        begin, end = cut(first, last, part, 0.0, 1.0)
        if end > begin:
            for g in range(len(CUBIC_POINTS)):
                xi = begin + CUBIC_POINTS[g] * (end - begin)
                weight = CUBIC_WEIGHTS[g] * (end - begin) * length
                basis = BASIS(xi, low, high, fields)
                own, other = hermite(xi), hermite(eta_first + (xi - first) * slope)
                for j in range(2):
                    psi = weight * (basis[0] if j == 0 else basis[1])
                    out[p, 0, j] += psi * own[0]
                    out[p, 1, j] += psi * own[1]
                    out[p, 2, j] -= psi * other[0]
                    out[p, 3, j] -= psi * other[1]


@kernel
def moments(bound, count, out):
    """Compute moments (p, 4, 2) of the first `count` pieces of a `Both` at the address `bound`."""
    both = unpack(bound, Both)
    view, pieces, fields = both.sides, both.out, PARAMETERS(both.numbers)
    p = 0
    while p < count:
        s, end, low, high = pieces.segment[p, 0], p, 1.0, 0.0
        while end < count and pieces.segment[end, 0] == s:
            low, high = min(low, pieces.ends[end, 0]), max(high, pieces.ends[end, 2])
            end += 1
        slave = slave_segment(s, view.at.slave, view.slave.segments, pieces.normal)
        for q in range(p, end):
            m = pieces.segment[q, 1]
            master = master_segment(view.master.segments[m, 0], view.master.segments[m, 1], view.at.master)
            put_moments(pieces.ends, q, facing(slave, master) * slave.edge.length(), low, high, fields, out)
        p = end


# --- derivatives ------------------------------------------------------------------------------------------------------


@section
def change_of_bent(view, out, p, length, covered, fields, bends, change):
    """Compute changes of the sums of moments and bends of piece p by six quantities and its length, at fixed bends."""
    low, high, eta_low, eta_high, covered_low, covered_high = quantities(out, p, covered[p])
    slope, zero = (eta_high - eta_low) / (high - low), 0.0 * low
    s, m = out.segment[p, 0], out.segment[p, 1]
    own, other = bends
    w00, w01, w10, w11 = zero, zero, zero, zero
    for part in range(PARTS):
        begin, end = cut(low, high, part, 0.0, 1.0)
        if end > begin:
            for g in range(len(CUBIC_POINTS)):
                xi = begin + CUBIC_POINTS[g] * (end - begin)
                weight = CUBIC_WEIGHTS[g] * (end - begin)
                first, second = BASIS(xi, covered_low, covered_high, fields)
                v, w = hermite(xi)
                t, u = hermite(eta_low + (xi - low) * slope)
                x = weight * (v * own[s, 0] + w * own[s, 2] - t * other[m, 0] - u * other[m, 2])
                y = weight * (v * own[s, 1] + w * own[s, 3] - t * other[m, 1] - u * other[m, 3])
                w00, w01, w10, w11 = w00 + first * x, w01 + first * y, w10 + second * x, w11 + second * y
    put_change(change, 0, 0, w00, length)
    put_change(change, 0, 1, w01, length)
    put_change(change, 1, 0, w10, length)
    put_change(change, 1, 1, w11, length)


@kernel
def moment_derivatives(bound, count, owner, bends, nodes_of_sides, out):
    """Compute derivatives of separations by the moments at fixed bends (s, 4), before T. Return the number of entries.

    `bound` is the address of a `Both`; nodes_of_sides: global numbers of the slave's nodes and then the master's
    out = row 2 k + component, column, value
    """
    both = unpack(bound, Both)
    row, column, values = out
    view, pieces, fields = both.sides, both.out, PARAMETERS(both.numbers)
    found = find(both, count, False)
    nodes, factors = np.empty(MOST_NODES, np.int64), np.empty((MOST_NODES, 2, NUMBERS))
    change, moved, e = np.zeros((NUMBERS, 2, 2)), np.zeros((2, 2)), 0
    for p in range(count):
        change_of_bent(view, pieces, p, found.lengths[p], found.covered, fields, bends, change)
        for z in range(collect(found, p, shares_of(both, found, p, False), nodes, factors)):
            for c in range(2):
                put_sum(change, factors[z, c], moved)
                for j in range(2):
                    k = owner[pieces.multiplier[p, j]]
                    if k >= 0:
                        for d in range(2):
                            row[e], column[e] = 2 * k + d, 2 * nodes_of_sides[nodes[z]] + c
                            values[e] = moved[j, d]
                            e += 1
    return e
