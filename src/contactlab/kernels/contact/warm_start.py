"""Where a contact solve starts: forces that go on as they went, and where they will move the nodes."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def extrapolate(now, before):
    """Forces (k,) that pressed in both last steps go on linearly, never below zero; `before` becomes `now`."""
    for k in range(now.size):
        last = now[k]
        if last > 0.0 and before[k] > 0.0:
            now[k] = max(2.0 * last - before[k], 0.0)
        before[k] = last


@kernel
def displaced(positions, compliance, force, out):
    """positions + compliance * force, all (N, 2)."""
    for n in range(positions.shape[0]):
        for c in range(2):
            out[n, c] = positions[n, c] + compliance[n, c] * force[n, c]
