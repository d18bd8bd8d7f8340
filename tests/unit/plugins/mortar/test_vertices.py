"""How far a slave turns at its nodes, and what it sees of the master there."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.vertices import facing_sums, slave_turn

from contactlab.testing.surfaces import chains

BELOW = np.array([[-3.0, -1.0], [3.0, -1.0]])


@pytest.mark.parametrize("angle", [-1.2, -0.4, 0.0, 0.7, 1.5])
def test_the_turn_is_the_sine_of_the_angle(angle: float) -> None:
    at = chains(np.array([[-1.0, 0.0], [0.0, 0.0], [np.cos(angle), np.sin(angle)]]), BELOW)
    assert slave_turn(1, at.nodes, at.slave.segments, at.slave.node_segments) == pytest.approx(abs(np.sin(angle)))


def test_the_turn_is_one_beyond_a_right_angle_and_at_ends_of_chains() -> None:
    at = chains(np.array([[-1.0, 0.0], [0.0, 0.0], [-0.5, 0.5]]), BELOW)
    for node in range(3):
        assert slave_turn(node, at.nodes, at.slave.segments, at.slave.node_segments) == 1.0


def test_master_normals_are_summed_by_the_length_that_a_multiplier_sees() -> None:
    draw = np.random.default_rng(1)
    multiplier = np.array([[0, 1], [1, 2], [2, 3]], np.int32)
    master = np.array([[1, 0], [2, 1], [3, 2]], np.int32)
    T, at = draw.uniform(size=(3, 2, 2)), draw.uniform(size=(4, 2))
    wanted, facing = np.array([0.0, 1.0, 0.0, 0.0]), np.full((4, 2), np.nan)
    facing_sums(3, multiplier, master, T, at, wanted, facing)
    expected = np.zeros((4, 2))
    for p in range(2):  # the third piece has no wanted multiplier
        along = at[master[p, 1]] - at[master[p, 0]]
        normal = np.array([along[1], -along[0]]) / np.hypot(*along)
        for k in range(2):
            expected[multiplier[p, k]] += T[p, :, k].sum() * normal
    np.testing.assert_allclose(facing, expected, atol=1e-15)
