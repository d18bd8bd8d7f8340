"""Reuse of factors of an earlier iteration for a later system with the same contact states.

Close to the solution of a step the matrix hardly changes: a few iterations of GMRES (Saad & Schultz 1986),
preconditioned by the old factors, cost a fraction of new factors. Their accuracy follows from the residual of the
equilibrium, so that Newton's iteration keeps its order (Dembo, Eisenstat & Steihaug 1982).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.implicit.factor import Factor

MOST = 12  # iterations; one costs about a twentieth of new factors
FORCING = 1e-2  # tolerance of a solution over the residual of the equilibrium
COARSEST, FINEST = 1e-3, 1e-13


class ReusedFactor:
    """Keeps the factors of a step; its results depend on this step alone.

    places  (m, 2) [mm] of the first m unknowns
    """

    def __init__(self, places: Floats | None = None) -> None:
        self.places = places
        self.factor: Factor | None = None
        self.kind: tuple[bytes, ...] = ()

    def forget(self) -> None:
        """Begin a new step: results must not depend on earlier trials."""
        self.factor = None

    def solve(self, matrix: Any, right: Floats, kind: tuple[bytes, ...], residual: float) -> Floats:
        """Solve for one right-hand side (n,).

        kind      which forces are unknowns: old factors serve only the same unknowns
        residual  relative residual of the equilibrium, which sets the accuracy; inf: full accuracy
        """
        if self.factor is not None and kind == self.kind and residual < np.inf:
            accuracy = min(COARSEST, max(FORCING * residual, FINEST))
            found = preconditioned(matrix, right, self.factor, accuracy)
            if found is not None:
                return found
        self.factor = None  # factors are most of the memory of a run: free the old ones first
        self.factor, self.kind = Factor(matrix, self.places), kind
        return self.factor.solve(right)


def preconditioned(matrix: Any, right: Floats, factor: Factor, accuracy: float) -> Floats | None:
    """Solve by GMRES with rows scaled by their largest entry: forces become displacements. None if too slow."""
    scale = 1.0 / _row_sizes(matrix)
    first = scale * right
    size = _dot(first, first) ** 0.5
    if size == 0.0:
        return np.zeros_like(right)
    basis, steps = [first / size], []
    triangle = np.zeros((MOST + 1, MOST))
    for j in range(MOST):
        step = factor.once(basis[j] / scale)
        image = scale * (matrix @ step)
        steps.append(step)
        # twice: once leaves basis vectors non-orthogonal by cancellation
        for _ in range(2):
            for i, vector in enumerate(basis):
                share = _dot(vector, image)
                triangle[i, j] += share
                image -= share * vector
        length = _dot(image, image) ** 0.5
        triangle[j + 1, j] = length
        if not np.isfinite(length):
            return None
        target = np.zeros(j + 2)
        target[0] = size
        part = triangle[: j + 2, : j + 1]
        weights = np.linalg.lstsq(part, target, rcond=None)[0]
        left = float(np.linalg.norm(target - part @ weights)) / size
        if left <= accuracy:
            combined: Floats = np.einsum("i,ij->j", weights, np.array(steps))
            return combined
        # at this rate it takes too long
        if length == 0.0 or (j >= 2 and np.log(left) * MOST > np.log(accuracy) * (j + 1)):
            return None
        basis.append(image / length)
    return None


def _dot(a: Floats, b: Floats) -> float:
    """Return the inner product; BLAS would start threads for it, and its sums would depend on their number."""
    return float(np.einsum("i,i", a, b))


def _row_sizes(matrix: Any) -> Floats:
    """Return the largest absolute entry of every row of a CSC matrix."""
    sizes = np.zeros(matrix.shape[0])
    np.maximum.at(sizes, matrix.indices, np.abs(matrix.data))
    return np.where(sizes > 0.0, sizes, 1.0)
