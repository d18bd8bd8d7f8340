"""Sparse matrices without SciPy's checks: equal to SciPy's own, to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_array, diags_array, vstack

from contactlab.implicit import sparse

DRAW = np.random.default_rng(3)
COUNT, ROWS, COLUMNS = 200, 7, 9
ROW, COLUMN = DRAW.integers(0, ROWS, COUNT), DRAW.integers(0, COLUMNS, COUNT)
VALUE = DRAW.uniform(-1.0, 1.0, COUNT)
ENTRIES = coo_array((VALUE, (ROW, COLUMN)), (ROWS, COLUMNS))
THERE = ENTRIES.tocsr()
HERE = sparse.summed(ROW, COLUMN, VALUE, (ROWS, COLUMNS))
EMPTY = sparse.summed(ROW[:0], COLUMN[:0], VALUE[:0], (ROWS, COLUMNS))
FACTORS = DRAW.uniform(-1.0, 1.0, ROWS)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (HERE, THERE),
        (sparse.summed_columns(ROW, COLUMN, VALUE, (ROWS, COLUMNS)), ENTRIES.tocsc()),
        (EMPTY, csr_array((ROWS, COLUMNS))),
        (sparse.transposed(HERE), THERE.T.tocsr()),
        (sparse.product(HERE, sparse.transposed(HERE)), THERE @ THERE.T.tocsr()),
        (sparse.product(EMPTY, sparse.transposed(HERE)), csr_array((ROWS, ROWS))),
        (sparse.total(HERE, HERE), THERE + THERE),
        (sparse.total(HERE, sparse.scaled(HERE, -np.ones(ROWS))), csr_array((ROWS, COLUMNS))),
        (sparse.picked(HERE, np.array([1, 4])), THERE[[1, 4]]),
        (sparse.picked(HERE, np.array([], np.int64)), csr_array((0, COLUMNS))),
        (sparse.stacked([HERE, EMPTY, HERE]), vstack([THERE, csr_array((ROWS, COLUMNS)), THERE], format="csr")),
        (sparse.scaled(HERE, FACTORS), (diags_array(FACTORS) @ THERE).tocsr()),
        (sparse.diagonal(FACTORS), diags_array(FACTORS).tocsr()),
    ],
)
def test_matrices_are_those_of_scipy(found: Any, expected: Any) -> None:
    assert found.format == expected.format
    assert found.shape == expected.shape
    assert found.nnz == expected.nnz
    np.testing.assert_array_equal(found.toarray(), expected.toarray())
    np.testing.assert_allclose((found @ found.T).toarray(), (expected @ expected.T).toarray(), atol=1e-14)


def test_rows_are_combined_as_by_a_product_with_the_transpose() -> None:
    np.testing.assert_array_equal(sparse.combined(HERE, FACTORS), THERE.T @ FACTORS)
    np.testing.assert_array_equal(sparse.rows_of(HERE), THERE.tocoo().row)
