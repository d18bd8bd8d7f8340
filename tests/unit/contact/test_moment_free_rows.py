"""Rows without sum and moment: the nearest to given ones, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array

from contactlab.contact.step_rows import MomentFreeRows, neighbours

NODES = 6
SLAVE, MASTER = np.array([[0, 1], [1, 2]]), np.array([[3, 4], [4, 5]])
DRAW = np.random.default_rng(7)
POSITION = np.array([[0.0, 0.1], [1.0, 0.0], [2.0, 0.1], [0.2, 0.0], [1.0, 0.0], [2.1, -0.1]])


@pytest.fixture
def rows() -> MomentFreeRows:
    """Two rows whose forces have no sum: one of five nodes, one of two nodes that lie on each other."""
    given = np.zeros((2, NODES, 2))
    given[0, [0, 1, 3, 4, 5]] = DRAW.uniform(-1.0, 1.0, (5, 2))
    given[0, 0] -= given[0].sum(axis=0)
    given[1, 1], given[1, 4] = (0.3, 1.0), (-0.3, -1.0)
    return MomentFreeRows(csr_array(given.reshape(2, -1)), neighbours([SLAVE, MASTER], NODES), POSITION)


def forces(rows: MomentFreeRows) -> np.ndarray:
    """Rows as forces on the nodes (2, N, 2)."""
    return np.asarray(rows.rows(np.arange(rows.shape[0])).todense()).reshape(-1, NODES, 2)


def moments(force: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Moments of forces (2, N, 2) at positions (N, 2)."""
    return np.asarray((position[:, 0] * force[..., 1] - position[:, 1] * force[..., 0]).sum(axis=1))


def test_sum_and_moment_vanish_by_the_least_change(rows: MomentFreeRows) -> None:
    """A least change is a combination of what it is to be free of: two translations and a turn of its nodes."""
    before = rows.given.copy()
    rows.about(POSITION)
    force = forces(rows)
    assert np.abs(force.sum(axis=1)).max() < 1e-14
    assert np.abs(moments(force, POSITION)).max() < 1e-14
    for number in range(2):
        own = rows.row == number
        at = POSITION[rows.node[own]]
        turn = np.stack([-at[:, 1], at[:, 0]], axis=1)
        moves = np.stack([np.tile([1.0, 0.0], len(at)), np.tile([0.0, 1.0], len(at)), turn.ravel()])
        change = (rows.values[own] - before[own]).ravel()
        assert np.linalg.lstsq(moves.T, change, rcond=None)[1].max() < 1e-28


def test_rigid_motions_change_nothing(rows: MomentFreeRows) -> None:
    """From start to end of a rotation by any angle and a shift: products with the motion, rows about its middle."""
    angle, shift = 0.7, np.array([3.0, -2.0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    end = POSITION @ turn.T + shift
    rows.about(0.5 * (POSITION + end))
    assert np.abs(rows.times(end - POSITION)).max() < 1e-14


def test_nodes_on_each_other_have_their_neighbours_to_turn_about(rows: MomentFreeRows) -> None:
    """Two coincident nodes alone have no arm; a hair's breadth between them asks for no more than a hair's change."""
    apart = POSITION.copy()
    apart[1, 1] += 1e-9
    rows.about(apart)
    given = np.zeros((NODES, 2))
    given[1], given[4] = (0.3, 1.0), (-0.3, -1.0)
    assert np.abs(forces(rows)[1] - given).max() < 1e-8


def test_derivatives_are_those_of_products_and_forces(rows: MomentFreeRows) -> None:
    """Central differences as the end of a step moves, and the middle with it by half."""
    start, motion, y = POSITION, 0.1 * DRAW.uniform(-1.0, 1.0, (NODES, 2)), np.array([2.0, 3.0])

    def at(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rows.about(start + 0.5 * moved)
        return rows.times(moved), rows.forces(y).ravel()

    direction, size = DRAW.uniform(-1.0, 1.0, (NODES, 2)), 1e-6
    high, low = at(motion + size * direction), at(motion - size * direction)
    at(motion)
    slope = (high[0] - low[0]) / (2.0 * size)
    np.testing.assert_allclose(rows.derivatives(motion, np.arange(2)) @ direction.ravel(), slope, rtol=0.0, atol=1e-8)
    # but for the change of the arms, which is as small as the share of a turn in the rows
    change = (high[1] - low[1]) / (2.0 * size)
    allowed = 1e-8 + np.abs(rows.share * y).sum() * np.abs(direction).max()
    np.testing.assert_allclose(rows.of_forces(y) @ direction.ravel(), change, rtol=0.0, atol=allowed)


def test_rows_of_one_side_alone_stay_as_they_are() -> None:
    """An obstacle without nodes: what pushes one side has a sum and a moment of its own."""
    given = np.zeros((1, NODES, 2))
    given[0, 1] = 0.0, 1.0
    rows = MomentFreeRows(csr_array(given.reshape(1, -1)), neighbours([SLAVE], NODES), POSITION)
    rows.about(POSITION)
    np.testing.assert_array_equal(np.asarray(rows.rows(np.arange(rows.shape[0])).todense()).reshape(1, NODES, 2), given)
