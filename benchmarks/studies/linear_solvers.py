"""Which sparse direct solver for the saddle point systems: times of one factorisation and solution, and their errors.

    python linear_solvers.py [LEVEL ...]

The systems are those of disc-on-block (deep, mortar-p0) at the fourth iteration of the first of five load steps. Every
solver solves the same ones in turn in one process; medians of CPU seconds of five, so that ratios mean something on a
busy machine. Packages that are not installed are left out with a line that says so.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from contactlab_statics import reuse
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

import contactlab
from contactlab.api import Floats
from contactlab.model.build import build

REPEAT = 5
REFINEMENTS = 30
System = tuple[Any, Floats]
Solver = Callable[[Any, Floats], tuple[Floats, float]]


def system(level: int, wanted: int = 4) -> System:
    """Matrix (CSC) and right-hand side of an iteration."""
    kept: list[System] = []

    class Keeping(reuse.Factor):  # type: ignore[misc]
        def solve(self, right: Floats) -> Floats:
            kept.append((self.matrix.copy(), right.copy()))
            return super().solve(right)

    scene = contactlab.load_scene("disc-on-block").with_({"level": level, "integrator": {"use": "newton", "steps": 5}})
    model = build(scene, scene.registry)
    original = reuse.Factor, reuse.preconditioned
    # every iteration is to have factors of its own
    reuse.Factor, reuse.preconditioned = Keeping, lambda *_: None
    try:
        model.bound_integrator().step(0.1)
    finally:
        reuse.Factor, reuse.preconditioned = original
    return kept[min(wanted, len(kept)) - 1]


def superlu(ordering: str, pivot: float, symmetric: bool) -> Solver:
    """SciPy's SuperLU; fill counts the entries of both factors."""

    def solve(matrix: Any, right: Floats) -> tuple[Floats, float]:
        lu = splu(matrix, permc_spec=ordering, diag_pivot_thresh=pivot, options={"SymmetricMode": symmetric})
        return np.asarray(lu.solve(right)), (lu.L.nnz + lu.U.nnz) / matrix.nnz

    return solve


def solvers() -> Iterator[tuple[str, Solver]]:
    """Those of SciPy, and what else is installed."""
    for ordering in ("MMD_AT_PLUS_A", "COLAMD", "MMD_ATA"):
        yield f"SuperLU {ordering}", superlu(ordering, 1.0, False)
    for pivot in (0.1, 1e-3):
        yield f"SuperLU MMD_AT_PLUS_A symmetric, pivot {pivot:g}", superlu("MMD_AT_PLUS_A", pivot, True)
    try:
        import pypardiso
    except ImportError:
        print("pypardiso is not installed: left out")
    else:

        def pardiso(matrix: Any, right: Floats) -> tuple[Floats, float]:
            # a solver of its own each time: the package's common one remembers factors of matrices that it has seen
            solver, rows = pypardiso.PyPardisoSolver(), matrix.tocsr()
            solver.factorize(rows)
            found = np.asarray(solver.solve(rows, right))
            solver.free_memory(everything=True)
            return found, float("nan")

        yield "PARDISO (pypardiso)", pardiso
    try:
        from sksparse import umfpack
    except ImportError:
        print("scikit-sparse with UMFPACK is not installed: left out")
    else:

        def umf(matrix: Any, right: Floats) -> tuple[Floats, float]:
            return np.asarray(umfpack.spsolve(matrix, right)), float("nan")

        yield "UMFPACK (scikit-sparse)", umf
    try:
        import qdldl
    except ImportError:
        print("qdldl is not installed: left out")
    else:

        def symmetric(matrix: Any, right: Floats) -> tuple[Floats, float]:
            # it factorises symmetric matrices only: the rest is left to refinement
            factors = qdldl.Solver(csc_matrix(0.5 * (matrix + matrix.T)))
            found = np.asarray(factors.solve(right))
            for _ in range(REFINEMENTS):
                rest = right - matrix @ found
                if np.linalg.norm(rest) <= 1e-12 * np.linalg.norm(right):
                    break
                found = found + factors.solve(rest)
            return found, float("nan")

        yield "QDLDL (qdldl) of the symmetric part, refined", symmetric
    try:
        import mumps
    except ImportError:
        print("python-mumps is not installed: left out")
    else:

        def multifrontal(matrix: Any, right: Floats) -> tuple[Floats, float]:
            context = mumps.Context()
            context.factor(matrix)
            return np.asarray(context.solve(right)), float("nan")

        yield "MUMPS (python-mumps)", multifrontal


def main(levels: list[int]) -> None:
    """A table per level."""
    for level in levels:
        matrix, right = system(level)
        skew = float(abs(matrix - matrix.T).max() / abs(matrix).max())
        print(f"\nlevel {level}: {matrix.shape[0]} unknowns, {matrix.nnz} entries, asymmetry {skew:.1e}")
        print("| solver | CPU s | fill | backward error |\n|---|---|---|---|")
        for name, solve in solvers():
            times, found, fill = [], right, 0.0
            for _ in range(REPEAT):
                began = process_time()
                found, fill = solve(matrix, right)
                times.append(process_time() - began)
            error = np.abs(right - matrix @ found).max() / (abs(matrix) @ np.abs(found) + np.abs(right)).max()
            print(f"| {name} | {median(times):.3f} | {fill:.1f} | {error:.0e} |", flush=True)


if __name__ == "__main__":
    main([int(level) for level in sys.argv[1:]] or [2, 4, 8])
