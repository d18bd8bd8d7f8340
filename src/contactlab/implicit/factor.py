"""Sparse direct solution of the linear systems."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from contactlab.api import Floats
from contactlab.implicit.dissection import FROM, dissected

PIVOT = 1e-3  # a diagonal entry above this part of its column is the pivot, which keeps the ordering's fill
BACKWARD = 1e-15  # componentwise backward error beyond which a solution is refined: pivots that small may grow entries
REFINEMENTS = 3


class SingularSystem(ArithmeticError):
    """The matrix has no inverse: something can move without resistance."""


class Factor:
    """A factorised matrix (CSC).

    places  (m, 2) [mm] of the first m unknowns, for the ordering of large systems: see `dissection`
    order   (n,) of elimination, if SuperLU does not find it
    """

    def __init__(self, matrix: Any, places: Floats | None = None) -> None:
        self.matrix = matrix
        self.order: NDArray[np.int64] | None = None
        ordered, ordering = matrix, "MMD_AT_PLUS_A"
        if places is not None and matrix.shape[0] >= FROM:
            self.order = dissected(matrix, places)
            ordered, ordering = _permuted(matrix, self.order), "NATURAL"
        try:
            # unpadded supernodes: explicit zeros cost more than they save at these sizes
            self.lu = splu(
                ordered, permc_spec=ordering, diag_pivot_thresh=PIVOT, relax=1, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise SingularSystem(str(error)) from error

    def once(self, right: Floats) -> Floats:
        """Solve once for one right-hand side (n,), without refinement."""
        if self.order is None:
            return np.asarray(self.lu.solve(right))
        solution = np.empty_like(right)
        solution[self.order] = self.lu.solve(right[self.order])
        return solution

    def solve(self, right: Floats) -> Floats:
        """Solve for one right-hand side (n,), refined until its backward error is round-off."""
        solution, sizes = self.once(right), magnitudes(self.matrix)
        for _ in range(REFINEMENTS):
            rest = right - self.matrix @ solution
            scale = sizes @ np.abs(solution) + np.abs(right)
            if not (np.abs(rest) > BACKWARD * scale).any():
                break
            solution = solution + self.once(rest)
        return solution


def magnitudes(matrix: Any) -> Any:
    """Return the matrix (CSC) of absolute values."""
    return csc_array((np.abs(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape)


def with_diagonal(matrix: Any, factor: float, diagonal: Floats) -> Any:
    """Return factor times a CSC matrix plus a diagonal, on its pattern; held nodes without stiffness need no entry."""
    column = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    place = np.flatnonzero(matrix.indices == column)
    data = factor * matrix.data
    data[place] += diagonal[column[place]]
    return csc_array((data, matrix.indices, matrix.indptr), matrix.shape)


def _permuted(matrix: Any, order: NDArray[np.int64]) -> Any:
    """Return the matrix (CSC) with rows and columns in another order."""
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    column = np.repeat(place, np.diff(matrix.indptr))
    return coo_array((matrix.data, (place[matrix.indices], column)), shape=matrix.shape).tocsc()
