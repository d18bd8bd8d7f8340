"""The loops of effects that look at whole bodies."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section


@kernel
def damp_vibration(first, last, reference, displacement, mass, velocity, rate, force):
    """Add -rate m (v - v_rigid) for each body, nodes first ... last - 1."""
    for b in range(first.size):
        total, x, y, px, py = 0.0, 0.0, 0.0, 0.0, 0.0
        for n in range(first[b], last[b]):
            m = mass[n]
            total += m
            x += m * (reference[n, 0] + displacement[n, 0])
            y += m * (reference[n, 1] + displacement[n, 1])
            px += m * velocity[n, 0]
            py += m * velocity[n, 1]
        x, y, px, py = x / total, y / total, px / total, py / total
        inertia, turn = 0.0, 0.0
        for n in range(first[b], last[b]):
            rx, ry = reference[n, 0] + displacement[n, 0] - x, reference[n, 1] + displacement[n, 1] - y
            inertia += mass[n] * (rx * rx + ry * ry)
            turn += mass[n] * (rx * velocity[n, 1] - ry * velocity[n, 0])
        turn /= inertia
        for n in range(first[b], last[b]):
            rx, ry = reference[n, 0] + displacement[n, 0] - x, reference[n, 1] + displacement[n, 1] - y
            force[n, 0] -= rate * mass[n] * (velocity[n, 0] - px + turn * ry)
            force[n, 1] -= rate * mass[n] * (velocity[n, 1] - py - turn * rx)


@section
def _centre(nodes, reference, displacement, mass):
    """Centre of mass [mm] and mass [t] of a body."""
    total, x, y = 0.0, 0.0, 0.0
    for n in nodes:
        total += mass[n]
        x += mass[n] * (reference[n, 0] + displacement[n, 0])
        y += mass[n] * (reference[n, 1] + displacement[n, 1])
    return x / total, y / total, total


@kernel
def attract(first, second, reference, displacement, mass, pull, force):
    """Add `pull` [N] to both bodies (node numbers each), towards the other's centre of mass."""
    ax, ay, a = _centre(first, reference, displacement, mass)
    bx, by, b = _centre(second, reference, displacement, mass)
    distance = np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    if distance == 0.0:
        return
    x, y = pull * (bx - ax) / distance, pull * (by - ay) / distance
    for n in first:
        force[n, 0] += mass[n] / a * x
        force[n, 1] += mass[n] / a * y
    for n in second:
        force[n, 0] -= mass[n] / b * x
        force[n, 1] -= mass[n] / b * y
