"""Sparse direct solution of the linear systems."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from contactlab.api import Floats


PIVOT = 1e-3  # a diagonal entry above this part of its column is taken as pivot, which keeps the ordering's fill


class SingularSystem(ArithmeticError):
    """The matrix has no inverse: something can move without resistance."""


class Factor:
    """A factorised matrix."""

    def __init__(self, matrix: Any) -> None:
        try:
            self.lu = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=PIVOT, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise SingularSystem(str(error)) from error

    def solve(self, right: Floats) -> Floats:
        """Solution for one right-hand side (n,)."""
        return np.asarray(self.lu.solve(right))
