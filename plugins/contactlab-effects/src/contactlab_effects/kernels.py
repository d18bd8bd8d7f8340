"""The loop of the damper."""

from __future__ import annotations

from contactlab.api.kernel import kernel


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
