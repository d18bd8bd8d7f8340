"""Sparse direct solution of the linear systems."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from contactlab.api import Floats

PIVOT = 1e-3  # a diagonal entry above this part of its column is taken as pivot, which keeps the ordering's fill
BACKWARD = 1e-15  # componentwise backward error beyond which a solution is refined: pivots that small may grow entries
REFINEMENTS = 3


class SingularSystem(ArithmeticError):
    """The matrix has no inverse: something can move without resistance."""


class Factor:
    """A factorised matrix (CSC)."""

    def __init__(self, matrix: Any) -> None:
        self.matrix = matrix
        try:
            # supernodes that are not padded: entries that are zero cost more than they save at these sizes
            self.lu = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=PIVOT, relax=1, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise SingularSystem(str(error)) from error

    def once(self, right: Floats) -> Floats:
        """Solution for one right-hand side (n,), as the factors give it."""
        return np.asarray(self.lu.solve(right))

    def solve(self, right: Floats) -> Floats:
        """Solution for one right-hand side (n,), refined until its backward error is that of round-off."""
        solution, sizes = self.once(right), magnitudes(self.matrix)
        for _ in range(REFINEMENTS):
            rest = right - self.matrix @ solution
            scale = sizes @ np.abs(solution) + np.abs(right)
            if not (np.abs(rest) > BACKWARD * scale).any():
                break
            solution = solution + self.once(rest)
        return solution


def magnitudes(matrix: Any) -> Any:
    """The matrix (CSC) of absolute values."""
    return csc_array((np.abs(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape)
