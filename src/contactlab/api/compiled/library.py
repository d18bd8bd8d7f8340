"""Machine code of a kernel that holds all it calls, and takes nothing from what else a process has loaded.

numba writes the kernels that a kernel calls into its machine code once more, optimised together with their caller,
and leaves it to its linker which of all copies of one kernel the whole process runs: the first that was loaded. Copies
may round differently, and which comes first depends on what a process has compiled, found in the cache or run before.
Here each copy belongs to its caller alone: what a kernel computes depends on its source, types and processor only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

SHARED = Linkage.linkonce_odr
"""How numba marks a copy that the linker may drop for another one."""


class ClosedLibrary(JITCodeLibrary):
    """The machine code of one kernel; copies of what it calls cannot be seen from outside."""

    def _finalize_final_module(self) -> None:
        self._shared_module = _for_callers(self._final_module)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == SHARED:
                function.linkage = Linkage.internal
        super()._finalize_final_module()


def _for_callers(module: Any) -> Any:
    """A copy that other kernels may write into themselves, as numba makes it; equal names are then there once."""
    copy = module.clone()
    for function in copy.functions:
        if not function.is_declaration and function.linkage == Linkage.external:
            function.linkage = SHARED
    return copy


class KernelCompiler(Compiler):
    """numba's own compiler, into a closed library."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a function of Python."""
        self.state.library = ClosedLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()  # before anything is in it, or it cannot be stored
        return super().compile_extra(func)
