"""How far a slave turns at its nodes, and what it sees of the master there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from contactlab.api.compiled.formulas import copied
from contactlab.formulas import segment_normals as normals
from contactlab.testing.surfaces import Chains, chains

BELOW = np.array([[-3.0, -1.0], [3.0, -1.0]])
turn_at, sum_facing, turn_normals = (copied(f, {}) for f in (normals.turn_at, normals.sum_facing, normals.turn_normals))


def seen(at: Chains, master: Any = BELOW) -> Any:
    """What the loops see of surfaces: the slave as it is, and positions of the master."""
    return SimpleNamespace(slave=at.slave, at=SimpleNamespace(slave=at.nodes, master=master))


@pytest.mark.parametrize("angle", [-1.2, -0.4, 0.0, 0.7, 1.5])
def test_turn_is_the_squared_sine_of_the_angle(angle: float) -> None:
    at = chains(np.array([[-1.0, 0.0], [0.0, 0.0], [np.cos(angle), np.sin(angle)]]), BELOW)
    assert turn_at(1, seen(at)) == pytest.approx(np.sin(angle) ** 2)


def test_turn_is_one_beyond_a_right_angle_and_at_ends_of_chains() -> None:
    at = chains(np.array([[-1.0, 0.0], [0.0, 0.0], [-0.5, 0.5]]), BELOW)
    for node in range(3):
        assert turn_at(node, seen(at)) == 1.0


def test_facing_sums_weigh_master_normals_by_the_length_that_a_multiplier_sees() -> None:
    draw = np.random.default_rng(1)
    multiplier = np.array([[0, 1], [1, 2], [2, 3]], np.int32)
    master = np.array([[1, 0], [2, 1], [3, 2]], np.int32)
    T, at = draw.uniform(size=(3, 2, 2)), draw.uniform(size=(4, 2))
    wanted, facing = np.array([0.0, 1.0, 0.0, 0.0]), np.full((4, 3), np.nan)
    pieces = SimpleNamespace(multiplier=multiplier, master=master, T=T)
    sum_facing(SimpleNamespace(at=SimpleNamespace(master=at)), pieces, 3, wanted, facing)
    expected = np.zeros((4, 3))
    for p in range(2):  # the third piece has no wanted multiplier
        along = at[master[p, 1]] - at[master[p, 0]]
        normal = np.array([along[1], -along[0]]) / np.hypot(*along)
        for k in range(2):
            expected[multiplier[p, k]] += T[p, :, k].sum() * np.append(normal, 1.0)
    np.testing.assert_allclose(facing, expected, atol=1e-15)


def ramp(value: float, low: float, high: float) -> float:
    """0 below low, 1 above high, a cubic without a kink between."""
    t = float(np.clip((value - low) / (high - low), 0.0, 1.0))
    return 3.0 * t**2 - 2.0 * t**3


@pytest.mark.parametrize("lean", [1e-4, 0.0023, 0.003, 0.1, 0.5])
@pytest.mark.parametrize("angle", [0.05, 0.15, 0.9])
def test_turn_at_vertices_goes_from_the_averaged_normal_to_the_masters(angle: float, lean: float) -> None:
    """Vertices by how much they turn, ends by how much they lean beyond what the chain turns beside them."""
    at = chains(np.array([[-1.0, 0.0], [0.0, 0.0], [np.cos(angle), np.sin(angle)]]), BELOW)
    master = np.array([[0.0, 0.0], [-np.cos(lean), -np.sin(lean)]])
    multiplier, nodes = np.array([[0, 1], [1, 2]], np.int32), np.array([[0, 1], [0, 1]], np.int32)
    averaged, up = np.tile([0.0, 1.0], (3, 1)), np.array([-np.sin(lean), np.cos(lean)])
    found, pieces = averaged.copy(), SimpleNamespace(multiplier=multiplier, master=nodes, T=np.ones((2, 2, 2)))
    turned = turn_normals(seen(at, master), pieces, 2, found)
    end = ramp(np.sin(lean) ** 2 / (np.sin(angle) ** 2 + 0.004**2), 0.25, 1.0)
    shares = [end, ramp(np.sin(angle) ** 2, 0.12**2, 0.2**2), end]
    assert turned == np.count_nonzero(shares)
    for normal, share in zip(found, shares, strict=True):
        expected = (1.0 - share) * averaged[0] + share * up
        np.testing.assert_allclose(normal, expected / np.hypot(*expected), atol=1e-14)
