"""Kernels are made without SciPy's linear algebra, and those of others still get it."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
from contactlab.api.compiled.kernel import kernel
import numba.np.arraymath
assert "scipy.linalg" not in sys.modules and "scipy.linalg.cython_blas" not in sys.modules
import numba, numpy as np

@numba.njit
def product(a, b):
    return a @ b

a = np.arange(6.0).reshape(2, 3)
assert np.array_equal(product(a, a.T.copy()), a @ a.T)
assert "scipy.linalg.cython_blas" in sys.modules
"""


def test_scipy_comes_with_the_first_kernel_that_calls_blas() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
