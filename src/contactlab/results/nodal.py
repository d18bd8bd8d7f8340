"""Nodal values from values of cells: at each node a plane is fitted to the cells around it.

Means of cells are those at their middles. A plain average would lose the peak at the skin of a body, and half of a
gradient at its corners; a fitted plane is exact for fields that are linear. Bodies are not averaged with each other.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from contactlab.api.arrays import Floats, Ints

ENOUGH = 3  # cells that a plane needs
FLAT = 1e-3  # ratio of the extents of a patch below which it gives no plane, but an average


def corners_of(cells: Ints) -> Ints:
    """The corners of cells (n, a): 3 of triangles, 4 of quadrilaterals."""
    return cells[:, : 3 if cells.shape[1] in (3, 6) else 4]


def nodal_values(position: Floats, cells: Ints, values: Floats) -> Floats:
    """Values (N, k) at nodes from values of cells (n, k); NaN at nodes of no cell.

    position (N, 2) of the nodes; cells (n, a) in these numbers, corners first (4, or 3 of triangles).
    """
    corners = corners_of(cells)
    middles = position[corners].mean(axis=1)
    # cells at each node (N, n)
    n, a = corners.shape
    pattern = (np.ones(n * a), (corners.ravel(), np.repeat(np.arange(n), a)))
    around = csr_array(pattern, shape=(len(position), n))
    few = np.diff(around.indptr) < ENOUGH
    wide = around @ around.T @ around  # cells that touch a cell at the node
    # rows of `wide` where there are few cells, else of `around`
    keep, take = (~few).astype(float), few.astype(float)
    patch = csr_array(around.multiply(keep[:, None]) + wide.multiply(take[:, None])).sorted_indices()
    counts = np.diff(patch.indptr)
    at = np.repeat(np.arange(len(position)), counts)
    offset = middles[patch.indices] - position[at]
    size = np.sqrt(np.bincount(at, (offset**2).sum(axis=1), len(position)) / np.maximum(counts, 1))
    offset /= np.maximum(size, 1e-300)[at, None]
    basis = np.column_stack([np.ones(len(at)), offset])
    matrix: Any = np.stack([[np.bincount(at, p * q, len(position)) for q in basis.T] for p in basis.T])
    right: Any = np.stack([[np.bincount(at, p * v[patch.indices], len(position)) for v in values.T] for p in basis.T])
    return _solved(matrix.transpose(2, 0, 1), right.transpose(2, 0, 1), counts)


def _solved(matrix: Floats, right: Floats, counts: Ints) -> Floats:
    """The plane's value at each node; the mean if cells lie on a line or are too few."""
    found = right[:, 0] / np.maximum(counts, 1)[:, None]
    second = matrix[:, 1:, 1:] - matrix[:, 1:, :1] * matrix[:, :1, 1:] / np.maximum(counts, 1)[:, None, None]
    least, most = np.linalg.eigvalsh(second).T if len(second) else (np.zeros(0), np.zeros(0))
    plane = (counts >= ENOUGH) & (least > FLAT**2 * most)
    found[plane] = np.linalg.solve(matrix[plane], right[plane])[:, 0]
    found[counts == 0] = np.nan
    return np.asarray(found)


def principal_stresses(stress: Floats) -> Floats:
    """Principal stresses (..., 3), largest first, of stresses (..., 4) with components xx, yy, zz, xy."""
    xx, yy, zz, xy = np.moveaxis(stress, -1, 0)
    middle, radius = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    return np.asarray(np.sort(np.stack([middle + radius, middle - radius, zz], axis=-1), axis=-1)[..., ::-1])
