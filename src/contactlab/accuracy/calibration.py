"""A fixed piece of work that is timed beside each run, so that costs of different machines and loads compare."""

from __future__ import annotations

from functools import cache
from time import process_time
from typing import Any

import numpy as np

SIZE = 40
TURNS = 3


@cache
def _matrix() -> Any:
    """Five-point Laplacian of SIZE x SIZE points: what statics factorise, only smaller."""
    from scipy.sparse import diags

    n = SIZE * SIZE
    return diags([-1.0, -1.0, 4.0, -1.0, -1.0], [-SIZE, -1, 0, 1, SIZE], shape=(n, n), format="csc")


def calibrate() -> float:
    """CPU time [s] of one factorisation, solution and sort, the least of three."""
    from scipy.sparse.linalg import splu

    matrix, right = _matrix(), np.ones(SIZE * SIZE)
    times = []
    for _ in range(TURNS):
        began = process_time()
        solution = splu(matrix).solve(right)
        np.sort(np.tile(solution, 20))
        times.append(process_time() - began)
    return min(times)
