"""T of the multipliers against dense matrices, and who is merged or dropped."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import chain, contributions, coupled, dense_coupling

from contactlab.contact.coupling import TIE, Coupling
from contactlab.kernels.contact.coupling import couple, unmerged

ROUND_OFF = 1e-13  # of numbers near one, through a T whose condition is below ten

COVERS = {
    "full": np.ones(9),
    "partial": np.array([0.0, 0.0, 0.3, 1.0, 1.0, 0.6, 0.0, 0.0, 0.0]),
    "two parts": np.array([1.0, 0.7, 0.0, 0.0, 1.0, 1.0, 0.0, 0.9, 0.2]),
    "hardly covered ends": np.array([0.0, 0.02, 1.0, 1.0, 1.0, 1.0, 0.03, 0.0, 0.0]),
}


@pytest.mark.parametrize("cover", COVERS.values(), ids=COVERS)
def test_solve_is_the_inverse_of_the_merged_matrix(cover: np.ndarray) -> None:
    surface = chain(10)
    multiplier, T = contributions(surface, cover)
    found = coupled(surface, multiplier, T)
    matrix = dense_coupling(found, multiplier, T)
    values = np.where(np.isin(np.arange(10), found.order), np.random.default_rng(2).uniform(size=10), 0.0)
    expected = np.linalg.solve(matrix, values)
    kept = found.order
    np.testing.assert_allclose(found.solve(values)[kept], expected[kept], atol=ROUND_OFF)


def test_couple_gives_merged_multipliers_the_value_of_their_owner_and_dropped_ones_none() -> None:
    surface = chain(10)
    multiplier, T = contributions(surface, COVERS["hardly covered ends"])
    found = coupled(surface, multiplier, T)
    np.testing.assert_array_equal(found.owner, [-1, 2, 2, 3, 4, 5, 6, 6, -1, -1])
    values = found.solve(np.where(np.isin(np.arange(10), found.order), 1.0, 0.0))
    assert values[1] == values[2] != 0.0
    assert values[0] == values[8] == values[9] == 0.0


def test_couple_sums_contributions_into_three_diagonals_and_the_cover() -> None:
    surface = chain(6)
    multiplier, T = contributions(surface, np.ones(5))
    found = coupled(surface, multiplier, T)
    matrix = dense_coupling(found, multiplier, T)
    np.testing.assert_allclose(found.table.diagonal, np.diag(matrix), atol=ROUND_OFF)
    np.testing.assert_allclose(found.table.lower[1:], np.diag(matrix, -1), atol=ROUND_OFF)
    np.testing.assert_allclose(found.table.upper[:-1], np.diag(matrix, 1), atol=ROUND_OFF)
    np.testing.assert_allclose(found.cover, matrix.sum(axis=0), atol=ROUND_OFF)


def test_a_merge_gives_the_neighbour_row_column_and_cover() -> None:
    surface = chain(5)
    multiplier, T = contributions(surface, np.ones(4))
    free, held = coupled(surface, multiplier, T), coupled(surface, multiplier, T, fixed=(2,))
    target = int(held.owner[2])
    assert target in (1, 3)
    assert len(held.order) == 4
    assert held.cover.sum() - held.cover[2] == pytest.approx(free.cover.sum(), abs=ROUND_OFF)
    # forces of a pressure that is the same everywhere are row sums, whoever is merged
    matrix = dense_coupling(held, multiplier, T)
    kept = held.order
    assert matrix[np.ix_(kept, kept)].sum() == pytest.approx(T.sum(), abs=ROUND_OFF)


def test_what_is_held_stays_merged_until_half_is_covered_and_what_is_free_until_a_fortieth() -> None:
    surface = chain(6)
    multiplier, T = contributions(surface, np.array([0.0, 0.2, 1.0, 1.0, 0.06]))
    found = coupled(surface, multiplier, T)
    assert found.free.sum() >= 4
    free = found.free.copy()
    end = int(np.flatnonzero(free)[0])
    found.hold(np.where(np.arange(6) == end, 0.0, 1.0))
    couple(len(multiplier), multiplier, T, found.table)
    assert not found.free[end]
    found.untie(np.ones(6))
    found.full[end] = found.cover[end] / 0.03  # between a fortieth and a twentieth of its length
    couple(len(multiplier), multiplier, T, found.table)
    assert found.free[end]
    found.let_go()
    couple(len(multiplier), multiplier, T, found.table)
    assert not found.free[end]


@pytest.mark.parametrize("freedom", [0.01, 0.5, 0.9])
def test_a_tie_keeps_sums_and_goes_from_merged_to_free(freedom: float) -> None:
    """T + t (e_k - e_n)(e_k - e_n)^T: a pressure that is the same everywhere crosses as before."""
    surface = chain(6)
    multiplier, T = contributions(surface, np.array([0.0, 0.2, 1.0, 1.0, 1.0]))
    found = coupled(surface, multiplier, T)
    end = int(np.flatnonzero(found.free)[0])
    matrix = dense_coupling(found, multiplier, T)
    found.hold(np.where(np.arange(6) == end, freedom, 1.0))
    couple(len(multiplier), multiplier, T, found.table)
    t, e = TIE * found.full[end] * (1.0 / freedom - 1.0), np.zeros(6)
    e[end], e[end + 1] = 1.0, -1.0
    kept = found.order
    tied = (matrix + t * np.outer(e, e))[np.ix_(kept, kept)]
    values = np.random.default_rng(5).uniform(size=6)
    np.testing.assert_allclose(found.solve(values)[kept], np.linalg.solve(tied, values[kept]), atol=ROUND_OFF)
    apart = found.solve(values)[end] - found.solve(values)[end + 1]
    found.let_go()
    couple(len(multiplier), multiplier, T, found.table)
    assert abs(apart) < abs(found.solve(values)[end] - found.solve(values)[end + 1])


def test_couple_tells_a_closed_chain_that_is_covered_all_around() -> None:
    surface = chain(6, closed=True)
    multiplier, T = contributions(surface, np.ones(6))
    found = Coupling(surface, 1, np.ones(6, np.bool_), np.zeros(6, np.bool_))
    found.full[:] = 1.0
    assert couple(6, multiplier, T, found.table) == -1
    assert couple(5, multiplier, T, found.table) == 6


def test_couple_sums_wide_contributions_as_narrow_ones() -> None:
    """The loop for two multipliers and the one for any number agree."""
    surface = chain(6)
    multiplier, T = contributions(surface, np.ones(5))
    spread = np.zeros((5, 3, 3))
    spread[:, :2, :2] = T
    wide = np.concatenate([multiplier, multiplier[:, :1]], axis=1)  # a third multiplier without weight
    one, other = coupled(surface, multiplier, T), coupled(surface, np.ascontiguousarray(wide), spread)
    for name in ("diagonal", "lower", "upper", "cover", "pivot"):
        np.testing.assert_allclose(getattr(other.table, name), getattr(one.table, name), atol=ROUND_OFF)


def test_unmerged_where_nothing_is_merged_and_d_is_t() -> None:
    T = np.random.default_rng(3).uniform(size=(4, 2, 2))
    owner = np.array([0, 1, -1, 3], np.int32)
    assert unmerged(owner, T, T.copy(), 4)
    assert not unmerged(np.array([0, 0, 2, 3], np.int32), T, T.copy(), 4)
    other = T.copy()
    other[3, 0, 1] += 1e-15
    assert not unmerged(owner, other, T, 4)
    assert unmerged(owner, other, T, 3)
