"""Sparse matrices by SciPy's own kernels, without the checks that cost SciPy 30 to 200 us an operation.

An iteration of a small model builds some fifty matrices of a few rows. Results are SciPy's to the last bit. Matrices
are stored by rows (CSR) with 32-bit indices.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import _sparsetools as kernels
from scipy.sparse import csc_array, csr_array

from contactlab.api import Floats

Indices = NDArray[np.integer[Any]]

_ATTRIBUTES = vars(csr_array((1, 1)))


def compressed(data: Floats, indices: Indices, start: Indices, shape: tuple[int, int], kind: Any = csr_array) -> Any:
    """Return the matrix of these arrays, which are neither checked nor copied if their indices have 32 bits."""
    matrix = kind.__new__(kind)
    vars(matrix).update(_ATTRIBUTES, data=data, indices=_short(indices), indptr=_short(start), _shape=shape)
    return matrix


def diagonal(values: Floats) -> csr_array:
    """Return the diagonal matrix of values."""
    place = np.arange(len(values) + 1, dtype=np.int32)
    return compressed(values, place[:-1], place, (len(values), len(values)))


def summed(row: Indices, column: Indices, value: Floats, shape: tuple[int, int]) -> csr_array:
    """Return the matrix of entries; entries at the same place are added."""
    data, indices, start = _room(len(value), shape[0])
    values = np.asarray(value, np.float64)
    kernels.coo_tocsr(*shape, len(value), _short(row), _short(column), values, start, indices, data)
    if not kernels.csr_has_sorted_indices(shape[0], start, indices):
        kernels.csr_sort_indices(shape[0], start, indices, data)
    kernels.csr_sum_duplicates(*shape, start, indices, data)
    return _pruned(data, indices, start, shape)


def summed_columns(row: Indices, column: Indices, value: Floats, shape: tuple[int, int]) -> csc_array:
    """Return the matrix of entries, stored by columns."""
    rows = summed(column, row, value, shape[::-1])
    return compressed(rows.data, rows.indices, rows.indptr, shape, csc_array)


def product(left: csr_array, right: csr_array) -> csr_array:
    """Return left @ right."""
    shape, one, other = (left.shape[0], right.shape[1]), _arrays(left), _arrays(right)
    data, indices, start = _room(kernels.csr_matmat_maxnnz(*shape, *one[:2], *other[:2]), shape[0])
    kernels.csr_matmat(*shape, *one, *other, start, indices, data)
    return _pruned(data, indices, start, shape)


def total(first: csr_array, second: csr_array) -> csr_array:
    """Return first + second without entries that are zero."""
    data, indices, start = _room(len(first.data) + len(second.data), first.shape[0])
    kernels.csr_plus_csr(*first.shape, *_arrays(first), *_arrays(second), start, indices, data)
    return _pruned(data, indices, start, first.shape)


def transposed(matrix: csr_array) -> csr_array:
    """Return the transpose, by rows as well."""
    rows, columns = matrix.shape
    data, indices, start = _room(len(matrix.data), columns)
    kernels.csr_tocsc(rows, columns, *_arrays(matrix), start, indices, data)
    return compressed(data, indices, start, (columns, rows))


def picked(matrix: csr_array, at: Indices) -> csr_array:
    """Return the rows `at`, in ascending order; the matrix itself if they are all its rows."""
    if len(at) == matrix.shape[0]:
        return matrix
    at, arrays = _short(at), _arrays(matrix)
    start = np.append(0, np.cumsum(np.diff(arrays[0])[at]))
    data, indices, _ = _room(start[-1], 0)
    kernels.csr_row_index(len(at), at, *arrays, indices, data)
    return compressed(data, indices, start, (len(at), matrix.shape[1]))


def scaled(matrix: csr_array, factors: Floats) -> csr_array:
    """Return the matrix with its rows times factors."""
    data = matrix.data * np.repeat(factors, np.diff(matrix.indptr))
    return compressed(data, matrix.indices, matrix.indptr, matrix.shape)


def stacked(matrices: Sequence[csr_array]) -> csr_array:
    """Return the rows of all matrices, one below the other."""
    if len(matrices) == 1:
        return matrices[0]
    count = np.concatenate([np.diff(one.indptr) for one in matrices])
    data, indices = (np.concatenate([getattr(one, name) for one in matrices]) for name in ("data", "indices"))
    return compressed(data, indices, np.append(0, np.cumsum(count)), (len(count), matrices[0].shape[1]))


def rows_of(matrix: csr_array) -> Indices:
    """Return the row of every entry."""
    return np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))


def combined(matrix: csr_array, factors: Floats) -> Floats:
    """Return the sum of all rows times `factors`."""
    return np.asarray(np.bincount(matrix.indices, scaled(matrix, factors).data, matrix.shape[1]), np.float64)


def _arrays(matrix: csr_array) -> tuple[Indices, Indices, Floats]:
    return _short(matrix.indptr), _short(matrix.indices), matrix.data


def _room(entries: int, rows: int) -> tuple[Floats, Indices, Indices]:
    return np.empty(entries), np.empty(entries, np.int32), np.empty(rows + 1, np.int32)


def _pruned(data: Floats, column: Indices, start: Indices, shape: tuple[int, int]) -> csr_array:
    return compressed(data[: start[-1]], column[: start[-1]], start, shape)


def _short(numbers: Indices) -> Indices:
    return np.asarray(numbers, np.int32)
