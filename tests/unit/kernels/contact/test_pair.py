"""A pair's step from positions to gaps, against dense matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP1

from contactlab.api import FactoredRows, Floats
from contactlab.kernels.contact import pair as kernels
from contactlab.kernels.contact.factored_rows import write_factored
from contactlab.testing.surfaces import curved, flat, pair_of

ROUND_OFF = 1e-12  # through a T whose condition is below ten
AT = curved()
MOVED = AT.nodes + np.random.default_rng(1).normal(scale=0.01, size=AT.nodes.shape)
OTHER = AT.nodes + np.random.default_rng(2).normal(scale=0.01, size=AT.nodes.shape)


@pytest.fixture
def pair() -> Any:
    """A pair of curved surfaces at its positions."""
    return pair_of(MortarP1(), AT)[0]


def weighted(pair: Any, slave: Floats, master: Floats) -> Floats:
    """Separations of the kept multipliers by dense sums over the pieces: T^-T (D^T x - M^T y)."""
    p, n, k = pair.pieces, pair.count, pair.slots
    T, right, owner = np.zeros((k, k)), np.zeros((k, 2)), pair.coupling.owner
    for e in range(n):
        own = owner[p.multiplier[e]]
        part = p.D[e].T @ slave[p.slave[e]] - p.M[e].T @ master[p.master[e]]
        for i in range(2):
            if own[i] >= 0:
                right[own[i]] += part[i]
                for j in range(2):
                    if own[j] >= 0:
                        T[own[i], own[j]] += p.T[e, i, j]
    kept = pair.coupling.order
    return np.asarray(np.linalg.solve(T[np.ix_(kept, kept)].T, right[kept]))


def test_place_takes_positions_and_tells_how_far_they_are_from_the_near_list(pair: Any) -> None:
    far = kernels.place(pair.address, MOVED, MOVED, MOVED, False)
    for at in (pair.at, pair.measured):
        np.testing.assert_array_equal(at.slave, MOVED[AT.slave.nodes])
        np.testing.assert_array_equal(at.master, MOVED[AT.master.nodes])
    assert far == np.abs(MOVED - AT.nodes).max()


def test_place_pushes_by_compliance_times_force_and_sums_lengths(pair: Any) -> None:
    compliance, force = np.random.default_rng(3).uniform(0.0, 0.1, size=(2, *AT.nodes.shape))
    kernels.place(pair.address, MOVED, compliance, force, True)
    x = (MOVED + compliance * force)[AT.slave.nodes]
    np.testing.assert_allclose(pair.at.slave, x, atol=1e-15)
    np.testing.assert_array_equal(pair.measured.slave, MOVED[AT.slave.nodes])
    expected = np.zeros(len(x))
    for i, j in AT.slave.segments:
        expected[[i, j]] += 0.5 * np.hypot(*(x[j] - x[i]))
    np.testing.assert_allclose(pair.coupling.full, expected, atol=1e-15)


def test_join_gives_the_separations_of_dense_matrices(pair: Any) -> None:
    kernels.place(pair.address, OTHER, OTHER, OTHER, False)
    assert kernels.join(pair.address, pair.count, True) == (len(pair.coupling.order), 0, 0)
    kept, expected = pair.coupling.order, weighted(pair, OTHER[AT.slave.nodes], OTHER[AT.master.nodes])
    np.testing.assert_allclose(pair.separation[kept], expected, atol=ROUND_OFF)
    np.testing.assert_allclose(pair.gaps[kept, 0], (pair.normals[kept] * expected).sum(axis=1), atol=ROUND_OFF)


def test_join_tells_how_wide_columns_have_to_be() -> None:
    """A slave of two edges over a master of thirty: columns of M need more than the eight weights they begin with."""
    found, _ = pair_of(MortarP1(), flat(edges=(2, 30)))
    width = found.columns.master.weight.shape[1]
    assert width > 8
    narrow = found.columns.master._replace(weight=np.zeros((found.slots, 3)))
    found.columns = found.columns._replace(master=narrow)
    found._bind()
    kept, slave, master = kernels.join(found.address, found.count, True)
    assert (kept, slave) == (len(found.coupling.order), 0)
    assert 3 < master <= width


def test_compute_gaps_at_leaves_the_pair_as_it_is(pair: Any) -> None:
    before, separation, gaps = pair.gaps.copy(), np.zeros((pair.slots, 2)), np.zeros((pair.slots, 2))
    angle = np.random.default_rng(4).uniform(0.0, 6.0, pair.slots)
    normals, at = np.stack([np.cos(angle), np.sin(angle)], axis=1), (MOVED[AT.slave.nodes], MOVED[AT.master.nodes])
    kernels.compute_gaps_at(pair.address, at, normals, separation, gaps)
    kept, expected = pair.coupling.order, weighted(pair, *at)
    np.testing.assert_allclose(separation[kept], expected, atol=ROUND_OFF)
    across = normals[kept, 1] * expected[:, 0] - normals[kept, 0] * expected[:, 1]
    np.testing.assert_allclose(gaps[kept, 1], across, atol=ROUND_OFF)
    np.testing.assert_array_equal(pair.gaps, before)


def test_write_factored_gives_columns_coupling_and_gaps(pair: Any) -> None:
    """T^-T of the rows that are written gives the separations that the pair has."""
    out = FactoredRows.allocate(pair.slots + 2, 400)
    count = write_factored(pair.address, 5, 0, out.packed.address)
    kept = pair.coupling.order
    assert count == len(kept)
    np.testing.assert_array_equal(out.slot[:count], kept + 5)
    np.testing.assert_array_equal(out.gap[:count], pair.gaps[kept, 0])
    x, right = AT.nodes, np.zeros((count, 2))
    for row in range(count):
        for z in range(out.start[row], out.start[row + 1]):
            right[row] += out.weight[z] * x[out.node[z]]
    # substitutions with T^T: T[row - 1, row] above, T[row, row - 1] below, one over the pivots
    for row in range(count):
        right[row] = out.inverse[row] * (right[row] - (out.above[row] * right[row - 1] if row else 0.0))
    for row in range(count - 2, -1, -1):
        right[row] -= out.inverse[row] * out.below[row + 1] * right[row + 1]
    own = np.where(out.own[:count, None] >= 0, x[out.own[:count]], 0.0)
    np.testing.assert_allclose(right + own, pair.separation[kept], atol=ROUND_OFF)
    small = FactoredRows.allocate(pair.slots + 2, 3)
    assert write_factored(pair.address, 0, 0, small.packed.address) == -1
