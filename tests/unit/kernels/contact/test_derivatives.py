"""Which contributions a moved node changes, and what changes of D, M and T do to forces and weighted gaps."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.api import Floats
from contactlab.kernels.contact import derivatives as kernels

K, S, R = 5, 6, 7  # multipliers, slave nodes, master nodes


def move(nodes: int, colours: Floats, colour: int, closed: bool = False, ring: int = 1) -> kernels.Move:
    following = np.arange(1, nodes + 1, dtype=np.int32)
    following[-1] = 0 if closed else -1
    preceding = np.arange(-1, nodes - 1, dtype=np.int32)
    preceding[0] = nodes - 1 if closed else -1
    return kernels.Move(following, preceding, colours.astype(np.int32), ring, 10, colour, 1, 0.5)


@pytest.mark.parametrize("closed", [False, True])
def test_moved_node_is_one_of_a_contribution_or_of_a_ring_around_it(closed: bool) -> None:
    """Every node gets a colour of its own: exactly those of the stretch are found, through the start of a loop too."""
    nodes = np.array([[3, 4], [0, 1], [11, 0] if closed else [10, 11]], np.int32)
    for p, own in enumerate(nodes):
        stretch = {int(n) + step for n in own for step in (-1, 0, 1)}
        expected = {n % 12 for n in stretch} if closed else {n for n in stretch if 0 <= n < 12}
        found = {kernels.moved_node(nodes, p, move(12, np.arange(12), c, closed)) for c in range(12)} - {-1}
        assert found == expected


def contributions(seed: int, count: int) -> tuple[tuple[Floats, ...], Floats]:
    draw = np.random.default_rng(seed)
    first = np.arange(count, dtype=np.int32)
    slave = np.ascontiguousarray(np.stack([first, first + 1], axis=1))
    return (slave, slave.copy(), slave.copy(), *draw.uniform(size=(3, count, 2, 2))), first


def test_differences_are_those_of_contributions_that_are_alike_and_the_whole_of_others() -> None:
    high, _ = contributions(1, 4)
    low, _ = contributions(2, 4)
    low[2][1] = low[2][1][::-1]  # the second one joins other nodes: no difference can be taken
    out = (*(np.zeros((20, 2), np.int32) for _ in range(3)), np.zeros(20, np.int32), *np.zeros((3, 20, 2, 2)))
    moved = move(5, np.zeros(5), 0, ring=0)
    count = kernels.differences(4, high, 4, low, 0, moved, 0, out)
    assert count == 5
    by_first = {}
    for e in range(count):
        by_first.setdefault(int(out[0][e, 0]), []).append(e)
    assert len(by_first[1]) == 2
    for p in (0, 2, 3):
        (e,) = by_first[p]
        np.testing.assert_allclose(out[5][e], 0.5 * (high[4][p] - low[4][p]), atol=1e-15)
        assert out[3][e] == 2 * (10 + p) + 1
    np.testing.assert_allclose(sum(out[4][e] for e in by_first[1]), 0.5 * (high[3][1] - low[3][1]), atol=1e-15)


def test_normal_differences_are_taken_on_the_side_without_a_jump() -> None:
    middle = np.zeros((3, 2))
    side = np.array([0.2, 0.0])
    high, low = middle + side, middle - side
    high[1] = [9.0, 0.0]
    low[2] = [-9.0, 0.0]
    out = np.zeros(9, np.int32), np.zeros(9, np.int32), np.zeros((9, 2))
    owners = np.arange(3, dtype=np.int32)[:, None]
    count = kernels.normal_differences(high, middle, low, owners, move(3, np.zeros(3), 0, ring=0), 0, out)
    assert count == 3
    np.testing.assert_allclose(out[2][:3], np.tile([0.2, 0.0], (3, 1)), atol=1e-15)


def changes(seed: int) -> tuple[tuple[Floats, ...], Floats, Floats, Floats]:
    """Changes of random contributions along one direction, as entries and as dense dD (s, k), dM (r, k), dT (k, k)."""
    draw, count = np.random.default_rng(seed), 8
    slave = draw.integers(0, S, (count, 2)).astype(np.int32)
    master = draw.integers(0, R, (count, 2)).astype(np.int32)
    multiplier = draw.integers(0, K, (count, 2)).astype(np.int32)
    moved = np.full(count, 2 * 3 + 1, np.int32)
    dD, dM, dT = draw.normal(size=(3, count, 2, 2))
    dense = np.zeros((S, K)), np.zeros((R, K)), np.zeros((K, K))
    for e in range(count):
        np.add.at(dense[0], np.ix_(slave[e], multiplier[e]), dD[e])
        np.add.at(dense[1], np.ix_(master[e], multiplier[e]), dM[e])
        np.add.at(dense[2], np.ix_(multiplier[e], multiplier[e]), dT[e])
    return (slave, multiplier, master, moved, dD, dM, dT), *dense


def triplets() -> tuple[Floats, Floats, Floats]:
    return np.zeros(400, np.int32), np.zeros(400, np.int32), np.zeros(400)


def summed(out: tuple[Floats, ...], count: int, rows: int) -> Floats:
    """What the entries of the one moved coordinate add up to, by row."""
    assert set(out[1][:count]) == {2 * 23 + 1}
    total = np.zeros(rows)
    np.add.at(total, out[0][:count], out[2][:count])
    return total.reshape(-1, 2)


NODES = np.arange(20, 20 + S, dtype=np.int32), np.arange(40, 40 + R, dtype=np.int32)
OWNER, WANTED = np.arange(K, dtype=np.int32), np.ones(K, np.bool_)


def test_force_derivatives_are_the_changes_of_d_and_m_and_those_of_couplings_that_of_t() -> None:
    entries, dD, dM, dT = changes(1)
    traction = np.random.default_rng(2).normal(size=(K, 2))
    force, coupling = triplets(), triplets()
    counts = kernels.force_derivatives(8, entries, OWNER, WANTED, traction, NODES, force, coupling)
    found = summed(force, counts[0], 2 * 50)
    np.testing.assert_allclose(found[NODES[0]], dD @ traction, atol=1e-13)
    np.testing.assert_allclose(found[NODES[1]], -dM @ traction, atol=1e-13)
    np.testing.assert_allclose(summed(coupling, counts[1], 2 * K), dT @ traction, atol=1e-13)


def test_gap_derivatives_are_the_changes_of_all_three() -> None:
    entries, dD, dM, dT = changes(3)
    draw, weight = np.random.default_rng(4), triplets()
    x, y, r = draw.normal(size=(S, 2)), draw.normal(size=(R, 2)), draw.normal(size=(K, 2))
    count = kernels.gap_derivatives(8, entries, OWNER, WANTED, (x, y), r, NODES, weight)
    np.testing.assert_allclose(summed(weight, count, 2 * K), dD.T @ x - dM.T @ y - dT.T @ r, atol=1e-13)
