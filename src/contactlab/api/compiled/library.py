"""Machine code of a kernel that contains everything it calls, independent of what else the process has loaded.

numba copies the functions that a kernel calls into its machine code and optimises them together with their caller. Of
all copies of one function, its linker then lets the whole process run the one that was loaded first. Copies may round
differently, and which is first depends on what the process compiled, found in the cache or ran before. Here each copy
belongs to its caller alone, so the result of a kernel depends on its source, its types and the processor only.

Since a part of a kernel only ever runs as such a copy, it is not optimised by itself, nor made machine code of.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.typed_passes import NativeLowering

from contactlab.api.compiled.call_types import CallTypes
from contactlab.api.compiled.passes import InlinedLowering, LoweringWithEntry, passes

SHARED = Linkage.linkonce_odr
"""How numba marks a copy that the linker may replace by another one."""


class ClosedLibrary(JITCodeLibrary):
    """The machine code of one kernel; the copies of what it calls are not visible from outside."""

    def _finalize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == SHARED:
                function.linkage = Linkage.internal
        super()._finalize_final_module()


class PartLibrary(JITCodeLibrary):
    """The intermediate code of a part of kernels and of what it calls, which never runs by itself."""

    def _optimize_final_module(self) -> None:
        """Left to the kernels that contain it."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None, as for a function that has no entry point."""
        return 0

    @property
    def codegen(self) -> Any:
        """Where a function's environment is set: each kernel has its own copy of that, too."""
        return _Nowhere


class _Nowhere:
    @staticmethod
    def set_env(env_name: str, env: Any) -> None:
        """Nothing of a part is in the memory of the process."""


class KernelCompiler(CompilerBase):
    """numba's own compiler, with a closed library as its output."""

    library: type[JITCodeLibrary] = ClosedLibrary
    lowering: type[NativeLowering] = LoweringWithEntry

    def define_pipelines(self) -> list[Any]:
        """Called by numba for the passes over what is compiled."""
        return [passes(self.state, self.lowering)]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a Python function."""
        self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.typingctx = CallTypes(self.state.typingctx)
        self.state.library.enable_object_caching()  # before anything is in it, or it cannot be stored
        made = super().compile_extra(func)
        for environment in made._find_referenced_environments():
            made.library.codegen.set_env(environment.env_name, environment)
        return made


class PartCompiler(KernelCompiler):
    """The same for a part of kernels."""

    library, lowering = PartLibrary, NativeLowering


class InlinedCompiler(PartCompiler):
    """The same for a part that is inlined wherever it is called."""

    lowering = InlinedLowering
