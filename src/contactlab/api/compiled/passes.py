"""numba's passes over a function, without two that kernels rarely need and that take long to find nothing to do.

One writes functions that are defined within a function into it, the other makes arithmetic with whole arrays one loop.

Whether a function has an entry point for Python, or is inlined, is said to the last pass alone: numba compiles its own
functions, such as `max`, again for callers of other options.
"""

from __future__ import annotations

from types import CodeType
from typing import Any

from numba.core import ir, types
from numba.core.compiler import DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typed_passes import NativeLowering, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes


def passes(state: Any, lowering: type) -> Any:
    """Those that numba's own compiler makes over what is to be compiled, in their order, the last one being given."""
    made = PassManager("kernel")
    for kind, text in DefaultPassBuilder.define_nopython_pipeline(state).passes:
        if kind is NopythonRewrites:
            made.add_pass(TypedRewrites, text)
        elif kind is NativeLowering:
            made.add_pass(lowering, text)
        elif kind is not InlineClosureLikes or has_functions(state.func_id.code):
            made.add_pass(kind, text)
    made.finalize()
    return made


def has_functions(code: CodeType) -> bool:
    """Whether a function defines others, or may make an array of a list that it writes down."""
    return "array" in code.co_names or any(isinstance(constant, CodeType) for constant in code.co_consts)


@register_pass(mutates_CFG=True, analysis_only=False)
class TypedRewrites(NopythonRewrites):
    """Rewriting what has types, where there is something to rewrite: new arrays, or entries by name."""

    _name = "kernel_rewrites"

    def run_pass(self, state: Any) -> bool:
        """Called by numba; returns whether anything may have changed."""
        found = state.typemap
        named = any(isinstance(kind, types.StringLiteral) for kind in found.values())
        return (named or _makes_arrays(state.func_ir, found)) and bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class LoweringWithEntry(NativeLowering):
    """Makes an entry point for Python, too."""

    _name = "kernel_lowering"

    def run_pass(self, state: Any) -> bool:
        """Called by numba."""
        state.flags.no_cpython_wrapper = False
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class InlinedLowering(NativeLowering):
    """Has the function inlined wherever it is called."""

    _name = "inlined_lowering"

    def run_pass(self, state: Any) -> bool:
        """Called by numba."""
        state.flags.forceinline = True
        return bool(super().run_pass(state))


def _makes_arrays(function: Any, found: Any) -> bool:
    """Whether an operation or a call has an array as its result: entries, fields and parts of arrays do not count."""
    return any(
        isinstance(one.value, ir.Expr)
        and one.value.op in ("unary", "binop", "inplace_binop", "call")
        and isinstance(found.get(one.target.name), types.Array)
        for block in function.blocks.values()
        for one in block.find_insts(ir.Assign)
    )
