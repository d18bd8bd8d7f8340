"""Machine code of a kernel that contains everything it calls, independent of what else the process has loaded.

numba copies the kernels that a kernel calls into its machine code and optimises them together with their caller. Of
all copies of one kernel, its linker then lets the whole process run the one that was loaded first. Copies may round
differently, and which is first depends on what the process compiled, found in the cache or ran before. Here each copy
belongs to its caller alone, so the result of a kernel depends on its source, its types and the processor only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

SHARED = Linkage.linkonce_odr
"""How numba marks a copy that the linker may replace by another one."""


class ClosedLibrary(JITCodeLibrary):
    """The machine code of one kernel; the copies of what it calls are not visible from outside."""

    def _finalize_final_module(self) -> None:
        self._shared_module = _for_callers(self._final_module)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == SHARED:
                function.linkage = Linkage.internal
        super()._finalize_final_module()


def _for_callers(module: Any) -> Any:
    """A copy for other kernels to include, marked as numba does it, so that equal names are linked once."""
    copy = module.clone()
    for function in copy.functions:
        if not function.is_declaration and function.linkage == Linkage.external:
            function.linkage = SHARED
    return copy


class KernelCompiler(Compiler):
    """numba's own compiler, with a closed library as its output."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a Python function."""
        self.state.library = ClosedLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()  # before anything is in it, or it cannot be stored
        return super().compile_extra(func)
