"""The scalars of one step in one call: a row of the buffer that recorders are given in blocks."""

from __future__ import annotations

import numpy as np
from numba import carray

from contactlab.api.kernel import kernel, summation
from contactlab.kernels.bound_arrays import pointer


@summation
def kinetic(mass, velocity):
    """1/2 sum m v.v of velocities (2N,), in any order."""
    total = 0.0
    for n in range(mass.size):
        total += mass[n] * (velocity[2 * n] * velocity[2 * n] + velocity[2 * n + 1] * velocity[2 * n + 1])
    return 0.5 * total


@kernel
def step_scalars(
    row, table, rows_table, dt, sweeps, iterations, residual, elements, contact, columns, works, count, pairs,
    conditions,
):  # fmt: skip
    """Both of the following in one call."""
    column = model_scalars(row, table, dt, sweeps, iterations, residual, elements, contact, columns, works)
    contact_scalars(row, rows_table, column, columns, count, pairs, conditions)


@kernel
def model_scalars(row, table, dt, sweeps, iterations, residual, elements, contact, columns, works):
    """Fill a row of the bound buffer up to the reactions; returns the next free column.

    table   of the arrays buffer (BLOCK, columns), state, mass, places (where clock, velocity, work and
            reaction begin in the state, -1: not there), support_start, support_nodes
    works   number of entries of the energy ledger
    """
    out = carray(pointer(table[0, 0]), (table[1, 0] // columns, columns), np.float64)[row]
    state = carray(pointer(table[0, 1]), (table[1, 1],), np.float64)
    places = carray(pointer(table[0, 3]), (4,), np.int64)
    start = carray(pointer(table[0, 4]), (table[1, 4],), np.int64)
    nodes = carray(pointer(table[0, 5]), (table[1, 5],), np.int64)
    out[0], out[1], out[2] = state[places[0] + 1], state[places[0]], dt
    out[3], out[4], out[5], out[6], out[7] = sweeps, iterations, residual, elements, contact
    out[8] = 0.0
    if places[1] >= 0:
        mass = carray(pointer(table[0, 2]), (table[1, 2],), np.float64)
        out[8] = kinetic(mass, state[places[1] : places[1] + 2 * mass.size])
    column = 9
    for i in range(works):
        out[column + i] = state[places[2] + i]
    column += works
    for s in range(start.size - 1):
        x, y = 0.0, 0.0
        for k in range(start[s], start[s + 1]):
            at = places[3] + 2 * nodes[k]
            x += state[at]
            y += state[at + 1]
        out[column], out[column + 1] = x, y
        column += 2
    return column


@kernel
def contact_scalars(row, table, column, columns, count, pairs, conditions):
    """Fill active, sticking and penetration of every pair, from `column` on.

    table       of the arrays buffer (BLOCK, columns), position (N, 2), multipliers (1 or 2, conditions),
                pair_start (first slot of each pair, end of the last), and of the rows start, node,
                normal_weight, slot, measure, bound
    count       rows in use

    Active are conditions with a force, sticking those of them below their friction bound;
    penetration is the deepest gap of the conditions at the end of the step [mm].
    """
    out = carray(pointer(table[0, 0]), (table[1, 0] // columns, columns), np.float64)[row]
    position = carray(pointer(table[0, 1]), (table[1, 1] // 2, 2), np.float64)
    forces = carray(pointer(table[0, 2]), (table[1, 2] // conditions, conditions), np.float64)
    first = carray(pointer(table[0, 3]), (pairs + 1,), np.int32)
    start = carray(pointer(table[0, 4]), (table[1, 4],), np.int32)
    node = carray(pointer(table[0, 5]), (table[1, 5],), np.int32)
    weight = carray(pointer(table[0, 6]), (table[1, 6] // 2, 2), np.float64)
    slot = carray(pointer(table[0, 7]), (table[1, 7],), np.int32)
    measure = carray(pointer(table[0, 8]), (table[1, 8],), np.float64)
    friction = table[1, 9] > 0
    bound = carray(pointer(table[0, 9]), (3, table[1, 9] // 3), np.float64)
    for i in range(3 * pairs):
        out[column + i] = 0.0
    for k in range(count):
        p = 0
        while slot[k] >= first[p + 1]:
            p += 1
        at = column + 3 * p
        pressed = forces[0, slot[k]]
        pulled = abs(forces[1, slot[k]]) if friction else 0.0
        if pressed > 0.0 or pulled > 0.0:
            out[at] += 1.0
            if friction:
                limit = bound[0, k] * pressed + min(bound[1, k] * measure[k], bound[2, k] * pressed)
                if pulled < limit * (1.0 - 1e-9):
                    out[at + 1] += 1.0
        across, along = 0.0, 0.0
        for z in range(start[k], start[k + 1]):
            across += weight[z, 0] * position[node[z], 0]
            along += weight[z, 1] * position[node[z], 1]
        out[at + 2] = max(out[at + 2], -(across + along))
