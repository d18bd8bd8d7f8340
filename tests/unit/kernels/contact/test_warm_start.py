"""Forces that go on from the last steps, and where they will move the nodes."""

from __future__ import annotations

import numpy as np

from contactlab.kernels.contact.warm_start import displaced, extrapolate


def test_extrapolate_goes_on_linearly_where_forces_pressed_twice_and_never_pulls() -> None:
    now, before = np.array([3.0, 1.0, 2.0, 0.0, 1.0]), np.array([2.0, 3.0, 0.0, 1.0, 1.0])
    last = now.copy()
    extrapolate(now, before)
    np.testing.assert_array_equal(now, [4.0, 0.0, 2.0, 0.0, 1.0])
    np.testing.assert_array_equal(before, last)


def test_displaced_nodes_move_by_compliance_times_force() -> None:
    positions, compliance, force = np.random.default_rng(1).uniform(size=(3, 7, 2))
    out = np.zeros((7, 2))
    displaced(positions, compliance, force, out)
    np.testing.assert_allclose(out, positions + compliance * force, rtol=1e-15)
