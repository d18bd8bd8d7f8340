"""The scalars of one step in one call: a row of the buffer for recorders."""

from __future__ import annotations

from contactlab.api.compiled.friction import STICKS, friction_limit
from contactlab.api.compiled.kernel import kernel, section, summation
from contactlab.api.compiled.unpack import unpack

MODEL = "d2 d1 d1 l1 l1 l1"
CONTACT = "d2 d2 d2 i1 i1 i1 d2 i1 d1 d1 d2 i1 d1 i1 i1"
ACTIVE, STICKING = 1, 2


@summation
def kinetic(mass, velocity):
    """Return 1/2 sum m v.v of velocities (2N,), in any order."""
    total = 0.0
    for n in range(mass.size):
        total += mass[n] * (velocity[2 * n] * velocity[2 * n] + velocity[2 * n + 1] * velocity[2 * n + 1])
    return 0.5 * total


@kernel
def step_scalars(
    row, bound, bound_rows, dt, sweeps, iterations, residual, elements, contact, works, count, factored
):  # fmt: skip
    """Call `model_scalars` and `contact_scalars` together."""
    column = model_scalars(row, bound, dt, sweeps, iterations, residual, elements, contact, works)
    contact_scalars(row, bound_rows, column, count, factored)


@kernel
def model_scalars(row, bound, dt, sweeps, iterations, residual, elements, contact, works):
    """Fill a row of the bound buffer up to the reactions. Return the next free column.

    bound   arrays buffer (BLOCK, columns), state, mass, places (positions of clock, velocity, work and
            reaction in the state, -1: absent), support_start, support_dofs
    works   number of entries of the energy balance
    """
    buffer, state, mass, places, start, dofs = unpack(bound, MODEL)
    out = buffer[row]
    out[0], out[1], out[2] = state[places[0] + 1], state[places[0]], dt
    out[3], out[4], out[5], out[6], out[7] = sweeps, iterations, residual, elements, contact
    out[8] = 0.0
    if places[1] >= 0:
        out[8] = kinetic(mass, state[places[1] : places[1] + 2 * mass.size])
    column = 9
    for i in range(works):
        out[column + i] = state[places[2] + i]
    column += works
    for s in range(start.size - 1):
        x, y = 0.0, 0.0
        for k in range(start[s], start[s + 1]):
            force = state[places[3] + dofs[k]]
            if dofs[k] % 2 == 0:
                x += force
            else:
                y += force
        out[column], out[column + 1] = x, y
        column += 2
    return column


@section
def _pair(first, slot):
    """Find the pair that a slot belongs to."""
    p = 0
    while slot >= first[p + 1]:
        p += 1
    return p


@kernel
def contact_scalars(row, bound, column, count, factored):
    """Fill active, sticking, penetration and changed of every pair, from `column` on.

    bound       arrays buffer (BLOCK, columns), position (N, 2), multipliers (1 or 2, conditions),
                pair_start (first slot of each pair, end of the last), of the rows start, node,
                normal_weight, slot, measure, offset, bound, of the factored rows slot and left;
                states (conditions,) of the last step, updated to this step, and scratch (conditions,)
    count       rows in use, factored rows of the other kind; in a step one of the two is zero

    Active are constraints with a force, sticking are active constraints below their friction bound;
    penetration is the deepest gap of the constraints at the end of the step [mm], changed the number of constraints
    became active or not, or sticking or not.
    """
    (
        buffer, position, forces, first, start, node, weight, slot, measure, offset, bounds, factored_slot, left,
        states, now,
    ) = unpack(bound, CONTACT)  # fmt: skip
    out, pairs, friction = buffer[row], first.size - 1, bounds.shape[1] > 0
    for i in range(4 * pairs):
        out[column + i] = 0.0
    for i in range(now.size):
        now[i] = 0
    for k in range(factored):
        at = column + 4 * _pair(first, factored_slot[k])
        if forces[0, factored_slot[k]] > 0.0:
            out[at] += 1.0
            now[factored_slot[k]] = ACTIVE
        out[at + 2] = max(out[at + 2], -left[k])
    for k in range(count):
        if slot[k] >= first[pairs]:
            continue  # a point at a corner, behind all contacts
        at = column + 4 * _pair(first, slot[k])
        pressed = forces[0, slot[k]]
        pulled = abs(forces[1, slot[k]]) if friction else 0.0
        if pressed > 0.0 or pulled > 0.0:
            out[at] += 1.0
            now[slot[k]] = ACTIVE
            if friction:
                limit = friction_limit(bounds[0, k], bounds[1, k], bounds[2, k], measure[k], pressed)
                if pulled < limit * STICKS:
                    out[at + 1] += 1.0
                    now[slot[k]] = STICKING
        across, along = offset[k], 0.0
        for z in range(start[k], start[k + 1]):
            across += weight[z, 0] * position[node[z], 0]
            along += weight[z, 1] * position[node[z], 1]
        out[at + 2] = max(out[at + 2], -(across + along))
    for p in range(pairs):
        changed = 0
        for i in range(first[p], first[p + 1]):
            changed += states[i] != now[i]
            states[i] = now[i]
        out[column + 4 * p + 3] = changed
