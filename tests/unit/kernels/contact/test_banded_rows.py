"""Columns of D and M, and the rows that T^-T makes of them, against dense matrices."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import COVER, SURFACE, columns_of, contributions, coupled, dense_rows

from contactlab.kernels.contact.banded_rows import CUT, entries, fill_columns, own_nodes
from contactlab.kernels.contact.tables import BandedRows


def test_fill_columns_sums_contributions() -> None:
    columns, dense, _, _ = columns_of()
    np.testing.assert_allclose(dense_rows(columns, 14), dense, atol=1e-15)


def test_fill_columns_tells_how_wide_a_column_is_that_does_not_fit() -> None:
    multiplier, T = contributions(SURFACE, COVER)
    found = coupled(SURFACE, multiplier, T)
    nodes = np.ascontiguousarray(3 * multiplier)
    assert fill_columns(len(multiplier), multiplier, nodes, T, found.owner, BandedRows.allocate(12, 6)) == 7


@pytest.mark.parametrize("seed", range(4))
def test_solved_rows_are_the_inverse_times_the_columns(seed: int) -> None:
    """Each weight to the cut, below which weights are left out: a dozen of them at most."""
    columns, dense, found, T = columns_of(seed)
    rows = found.rows(columns, BandedRows.allocate(12, 2))  # too narrow at first
    expected = np.linalg.solve(T.T, dense)
    kept = found.order
    np.testing.assert_allclose(dense_rows(rows, 14)[kept], expected[kept], atol=100.0 * CUT)


def test_inverse_transposed_is_that_of_the_dense_matrix() -> None:
    _, _, found, T = columns_of()
    rows = found.inverse_transposed(BandedRows.allocate(12, 1))
    kept = found.order
    np.testing.assert_allclose(dense_rows(rows, 12)[kept], np.linalg.inv(T.T)[kept], atol=100.0 * CUT)


def test_own_nodes_are_rows_of_the_identity() -> None:
    _, _, found, _ = columns_of()
    rows = BandedRows.allocate(12, 1)
    own_nodes(found.bound.address, 12, rows)
    np.testing.assert_array_equal(dense_rows(rows, 12)[found.order], np.eye(12)[found.order])


def test_entries_are_the_weights_above_the_cut_of_the_chosen_rows() -> None:
    columns, dense, _, _ = columns_of()
    chosen, cut = np.array([2, 7, 9], np.int32), 0.3
    row, column, value = np.zeros(60, np.int32), np.zeros(60, np.int32), np.zeros(60)
    count = entries(chosen, columns, cut, row, column, value)
    found = np.zeros_like(dense)
    found[row[:count], column[:count]] = value[:count]
    expected = np.where(np.abs(dense) > cut, dense, 0.0)
    expected[np.setdiff1d(np.arange(12), chosen)] = 0.0
    np.testing.assert_array_equal(found, expected)
