"""Sparse direct solution of the linear systems, and reuse of factors of an earlier iteration.

Close to the solution of a step the matrix hardly changes: with the same contact states a few iterations of GMRES (Saad
& Schultz 1986), preconditioned by the old factors, cost a fraction of new factors. Their accuracy follows from the
residual of the equilibrium, so that Newton's iteration keeps its order (Dembo, Eisenstat & Steihaug 1982).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from contactlab.api import Floats
from contactlab.implicit.dissection import FROM, dissected
from contactlab.implicit.sparse import compressed

PIVOT = 1e-3  # a diagonal entry above this part of its column is the pivot, which keeps the ordering's fill
BACKWARD = 1e-15  # componentwise backward error beyond which a solution is refined: pivots that small may grow entries
REFINEMENTS = 3
MOST = 12  # iterations of GMRES; one costs about a twentieth of new factors
FORCING = 1e-2  # tolerance of a solution over the residual of the equilibrium
COARSEST, FINEST = 1e-3, 1e-13


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
    return compressed(np.abs(matrix.data), matrix.indices, matrix.indptr, matrix.shape, csc_array)


def with_diagonal(matrix: Any, factor: float, diagonal: Floats) -> Any:
    """Return factor times a CSC matrix plus a diagonal, on its pattern; held nodes without stiffness need no entry."""
    column = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    place = np.flatnonzero(matrix.indices == column)
    data = factor * matrix.data
    data[place] += diagonal[column[place]]
    return compressed(data, matrix.indices, matrix.indptr, matrix.shape, csc_array)


def _permuted(matrix: Any, order: NDArray[np.int64]) -> Any:
    """Return the matrix (CSC) with rows and columns in another order."""
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    column = np.repeat(place, np.diff(matrix.indptr))
    return coo_array((matrix.data, (place[matrix.indices], column)), shape=matrix.shape).tocsc()


# --- reuse ----------------------------------------------------------------------------------------------------------


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
