"""Sparse direct solution of the linear systems."""

from __future__ import annotations

from typing import Any

import numpy as np
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
        self.size = abs(matrix)
        try:
            self.lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=PIVOT, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SingularSystem(str(error)) from error

    def solve(self, right: Floats) -> Floats:
        """Solution for one right-hand side (n,), refined until its backward error is that of round-off."""
        solution = np.asarray(self.lu.solve(right))
        for _ in range(REFINEMENTS):
            rest = right - self.matrix @ solution
            scale = self.size @ np.abs(solution) + np.abs(right)
            if not (np.abs(rest) > BACKWARD * scale).any():
                break
            solution = solution + self.lu.solve(rest)
        return solution
