"""numba's array functions without SciPy's linear algebra, which takes a tenth of a second to be imported.

numba imports `scipy.linalg.cython_blas` to see whether it is there, and again when a kernel calls a function of BLAS.
No kernel of ours does, and SciPy is always installed: the first of the two may be spared.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType

ASKED_FOR = "scipy.linalg.cython_blas"


def import_array_functions() -> None:
    """Import them while another module stands for that of SciPy; a kernel that calls BLAS imports the real one."""
    if ASKED_FOR in sys.modules or "numba.np.arraymath" in sys.modules:
        return
    sys.modules[ASKED_FOR] = ModuleType(ASKED_FOR)
    try:
        import_module("numba.np.arraymath")
    finally:
        del sys.modules[ASKED_FOR]
