"""T of the multipliers against dense matrices, and who is merged or dropped."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import chain, contributions, coupled, dense_coupling

from contactlab.kernels.contact.coupling import TIE, Coupling, couple

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
