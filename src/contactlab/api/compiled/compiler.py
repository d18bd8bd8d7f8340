"""Compilation of kernels: all contact with numba except the decorators.

Machine code of a kernel contains everything it calls, independent of what else the process has loaded. numba copies the
functions that a kernel calls into its machine code and optimises them together with their caller. Of all copies of one
function, its linker then lets the whole process run the first copy loaded. Copies may round differently, and
the first depends on earlier work of the process. Here each copy belongs to its
caller alone (`ClosedLibrary`), so the result of a kernel depends on its source, its types and the processor only.

Since a part of a kernel only ever runs as such a copy, it is neither optimised by itself, nor made machine code
(`PartLibrary`). Only the last pass knows whether a function has an entry point for Python, or is inlined: numba
compiles its own functions, such as `max`, again for callers of other options.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import cached_property
from time import thread_time
from typing import Any, cast

import numba
from llvmlite.binding import Linkage
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering

from contactlab.api.compiled.locks import kernel_locked

OPTIONS: dict[str, Any] = {
    "error_model": "numpy", "fastmath": {"contract"}, "nogil": True, "no_cfunc_wrapper": True,
    "no_cpython_wrapper": True,
}  # fmt: skip
# explicit: otherwise a part would take this option from the first kernel that calls it
COUNTED: dict[str, Any] = {**OPTIONS, "_nrt": True}


SHARED = Linkage.linkonce_odr
"""Numba's mark of a copy that the linker may replace by another copy."""


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
        """Leave optimisation to the kernels that contain it."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, as for a function without entry point."""
        return 0

    @property
    def codegen(self) -> Any:
        """Object that sets a function's environment: each kernel has its own copy of the environment, too."""
        return _Nowhere


class _Nowhere:
    @staticmethod
    def set_env(env_name: str, env: Any) -> None:
        """Do nothing: the process's memory contains no part."""


@register_pass(mutates_CFG=True, analysis_only=False)
class LoweringWithEntry(NativeLowering):
    """Lowering that also makes an entry point for Python."""

    _name = "kernel_lowering"

    def run_pass(self, state: Any) -> bool:
        """Run the pass; called by numba."""
        state.flags.no_cpython_wrapper = False
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class InlinedLowering(NativeLowering):
    """Lowering that inlines the function wherever it is called."""

    _name = "inlined_lowering"

    def run_pass(self, state: Any) -> bool:
        """Run the pass; called by numba."""
        state.flags.forceinline = True
        return bool(super().run_pass(state))


class KernelCompiler(CompilerBase):
    """numba's own compiler, with a closed library as its output and a last pass of ours."""

    library: type[JITCodeLibrary] = ClosedLibrary
    lowering: type[NativeLowering] = LoweringWithEntry

    def define_pipelines(self) -> list[Any]:
        """Return numba's passes with the last one replaced; called by numba."""
        made = PassManager("kernel")
        for kind, text in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            made.add_pass(self.lowering if kind is NativeLowering else kind, text)
        made.finalize()
        return [made]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a Python function."""
        self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()  # before anything is in it, or it cannot be stored
        made = super().compile_extra(func)
        for environment in made._find_referenced_environments():
            made.library.codegen.set_env(environment.env_name, environment)
        return made


class PartCompiler(KernelCompiler):
    """Compiler for a part of kernels."""

    library, lowering = PartLibrary, NativeLowering


class InlinedCompiler(PartCompiler):
    """Compiler for a part that is inlined wherever it is called."""

    lowering = InlinedLowering


class Compilation:
    """CPU seconds spent by this process on compiling kernels and loading them from the cache.

    Garbage collection is off meanwhile: it would walk through a million short-lived objects in vain. `listener` is
    called with each kernel that Python calls, before it is compiled or loaded. `depth` is above zero during a
    compilation, in which the kernels that this one calls are compiled as well.
    """

    def __init__(self) -> None:
        self.seconds, self.depth, self._began, self._collected = 0.0, 0, 0.0, False
        self.listener: Callable[[Any], None] | None = None

    def tell(self, kernel: Any) -> None:
        """Notify the listener that a kernel is about to be compiled or loaded, except kernels that it calls."""
        if self.listener is not None and not self.depth:
            self.listener(kernel)

    def __enter__(self) -> None:
        if not self.depth:
            self._began, self._collected = thread_time(), gc.isenabled()
            gc.disable()
        self.depth += 1

    def __exit__(self, *raised: object) -> None:
        self.depth -= 1
        if not self.depth:
            if self._collected:
                gc.enable()
            self.seconds += thread_time() - self._began


COMPILATION = Compilation()


class Kernel(CPUDispatcher):
    """A kernel called from Python. Kernels that call it call its `part`."""

    compiler = KernelCompiler

    @cached_property
    def part(self) -> Part:
        """The same function for other kernels: it gets machine code of its own only when Python calls it."""
        made = dispatcher(Part, self.py_func, {name: self.targetoptions[name] for name in COUNTED})
        return cast(Part, made)

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.part)

    def compile(self, sig: Any) -> Any:
        """Compile at the first call with arguments of new types."""
        COMPILATION.tell(self)
        try:
            with kernel_locked(self), COMPILATION:
                return super().compile(sig)
        except RuntimeError as error:
            # an interrupt that came while LLVM handed over machine code, in a callback that drops what is raised
            if str(error).startswith("no compiled object yet"):
                raise KeyboardInterrupt from error
            raise


class Part(CPUDispatcher):
    """A function that kernels call: compiled within each of them, without an entry point for Python.

    It gets one when Python calls it. Literal arguments are plain numbers: a new literal causes no compilation.
    """

    compiler = PartCompiler

    @cached_property
    def with_entry(self) -> Callable[..., Any]:
        """The same function compiled with an entry point for Python."""
        return dispatcher(Kernel, self.py_func, COUNTED)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Call the function with an entry point, from Python."""
        return self.with_entry(*arguments, **named)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the signature of a call from a kernel."""
        return super().get_call_template([types.unliteral(argument) for argument in args], kws)


class Inlined(Part):
    """A function that is inlined wherever it is called."""

    compiler = InlinedCompiler


def dispatcher(
    kind: type[Kernel | Part], function: Callable[..., Any], options: dict[str, Any], cached: bool = False
) -> Callable[..., Any]:
    """Return a dispatcher of the given class, else as made by `njit`; the function itself if numba is switched off."""
    if numba.config.DISABLE_JIT:
        return function
    made = kind(
        py_func=function,
        targetoptions={"nopython": True, "boundscheck": None, **options},
        pipeline_class=kind.compiler,
    )
    if cached:
        made._cache = FunctionCache(function)  # type: ignore[union-attr]
    return made
