"""Kernels from the disk without numba's knowledge of what can be compiled, which takes a twentieth of a start.

numba registers all of its implementations of Python's and NumPy's functions, in modules that nothing else has imported,
before it loads the first kernel. Machine code needs none of them; the compiler registers them itself when it begins.
"""

from __future__ import annotations

from typing import Any

from numba.core.caching import FunctionCache
from numba.core.runtime import rtsys


class KernelCache(FunctionCache):
    """numba's own cache on the disk, but that it loads a kernel with what its machine code calls, and no more."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kernel for arguments of these types; None where it is not stored."""
        rtsys.initialize(target_context)  # counting of references to arrays
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)
