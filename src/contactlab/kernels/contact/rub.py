"""Friction under given normal forces: tangential multipliers by projected Gauss-Seidel. `rows` are `Rows`."""

from __future__ import annotations

from contactlab.api.compiled.friction import friction_limit
from contactlab.api.compiled.kernel import kernel


@kernel
def push(count, rows, multipliers, force):
    """Add the nodal forces of all rows."""
    for row in range(count):
        y = multipliers[0, rows.slot[row]]
        t = multipliers[1, rows.slot[row]] if rows.slip.size > 0 else 0.0
        for z in range(rows.start[row], rows.start[row + 1]):
            for c in range(2):
                force[rows.node[z], c] += y * rows.normal_weight[z, c]
                if t != 0.0:
                    force[rows.node[z], c] += t * rows.tangent_weight[z, c]


@kernel
def start_slips(count, rows, current, predicted):
    """Compute slips of the rows at the predicted positions, along their tangents at the start of the step."""
    for row in range(count):
        slid = 0.0
        for z in range(rows.start[row], rows.start[row + 1]):
            for c in range(2):
                slid += rows.tangent_weight[z, c] * (predicted[rows.node[z], c] - current[rows.node[z], c])
        rows.slip[row] = slid


@kernel
def rub(count, rows, compliance, multipliers, force, tolerance, sweeps):
    """Iterate tangential multipliers until none moves its row by `tolerance` segments. Return (sweeps, last change).

    `force` holds the nodal forces of all multipliers, and is updated.
    """
    change = 0.0
    for sweep in range(sweeps):
        change = 0.0
        for place in range(count):
            row = place if sweep % 2 == 0 else count - 1 - place
            k, pivot, slip = rows.slot[row], 0.0, rows.slip[row]
            for z in range(rows.start[row], rows.start[row + 1]):
                n = rows.node[z]
                for c in range(2):
                    w = rows.tangent_weight[z, c]
                    pivot += w * w * compliance[n, c]
                    slip += w * compliance[n, c] * force[n, c]
            normal, old = max(multipliers[0, k], 0.0), multipliers[1, k]
            limit = friction_limit(
                rows.bound[0, row], rows.bound[1, row], rows.bound[2, row], rows.measure[row], normal
            )
            new = min(max(old - slip / pivot, -limit), limit) if pivot > 0.0 else 0.0
            if new == old:
                continue
            multipliers[1, k] = new
            change = max(change, abs(new - old) * pivot / rows.size[row])
            for z in range(rows.start[row], rows.start[row + 1]):
                for c in range(2):
                    force[rows.node[z], c] += (new - old) * rows.tangent_weight[z, c]
        if change <= tolerance:
            return sweep + 1, change
    return sweeps, change
