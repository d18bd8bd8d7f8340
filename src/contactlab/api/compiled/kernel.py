"""The one decorator for compiled kernels, and the scalar functions that vectorise.

Kernels take contiguous arrays, fill the outputs they are given and allocate nothing.

`kernel`  for block kernels: division errors give inf/nan as in NumPy (the check would stop
          vectorisation), multiply-add contraction is allowed, reassociation is not, so results do
          not depend on block size; the interpreter lock is released; machine code is cached on disk.
          One whose name begins with an underscore is called by other kernels alone: it has no
          Python entry point, which saves a third of the compile time.
`table_kernel`  for kernels on the arrays of a table (`unpack`): they count no references to arrays and can make
          none. Counting costs more than a short loop does, and numba counts whenever it takes an array out of a
          table; who bound the arrays keeps them.
`point`   for functions of one point called inside kernels: always inlined, no entry from Python either.
`section` for pieces of a long kernel: they cost no compilation of their own.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import cached_property
from time import thread_time
from typing import Any

import numba
import numpy as np
from numba import njit, types
from numba.core.registry import CPUDispatcher
from numba.extending import intrinsic

from contactlab.api.compiled.cache import cache_folder
from contactlab.api.compiled.library import KernelCompiler
from contactlab.api.compiled.locks import kernel_locked

__all__ = ["exp", "kernel", "log", "point", "power", "section", "summation", "table_kernel"]

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}, "nogil": True}


# said in so many words, or a kernel would do as the first one that calls it does
_COUNTED: dict[str, Any] = {**_OPTIONS, "_nrt": True}
_ENTRY: dict[str, Any] = {"no_cfunc_wrapper": True}
_NO_ENTRY: dict[str, Any] = {**_ENTRY, "no_cpython_wrapper": True}


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a block kernel; see the module text for what is fixed."""
    return _compiled(function, _COUNTED)


def table_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a block kernel that counts no references to arrays: it may make none, numba says so where it does."""
    return _compiled(function, {**_OPTIONS, "_nrt": False})


def summation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel whose sums may be taken in any order, as wide as the processor adds.

    The last digits then depend on the processor: for numbers that are looked at, not for those that a run goes on with.
    """
    return _compiled(function, {**_COUNTED, "fastmath": {"contract", "reassoc"}})


def _compiled(function: Callable[..., Any], options: dict[str, Any]) -> Callable[..., Any]:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_folder(function.__code__.co_filename)
    try:
        if function.__name__.startswith("_"):
            return _dispatcher(_InnerKernel, function, {**_NO_ENTRY, **options}, cached=True)
        return _dispatcher(Kernel, function, {**_ENTRY, **options}, cached=True)
    finally:
        numba.config.CACHE_DIR = before


def _dispatcher(
    kind: type[CPUDispatcher], function: Callable[..., Any], options: dict[str, Any], cached: bool = False
) -> Callable[..., Any]:
    """What `njit` would make of a function, of a class of ours; the function itself where numba is switched off."""
    if numba.config.DISABLE_JIT:
        return function
    made = kind(
        py_func=function,
        targetoptions={"nopython": True, "boundscheck": None, **options},
        pipeline_class=KernelCompiler,
    )
    if cached:
        made.enable_caching()
    return made


def point(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of one point that is inlined into every kernel that calls it."""
    return _dispatcher(_Inner, function, {"forceinline": True, **_NO_ENTRY, **_OPTIONS})


class Compilation:
    """CPU seconds that this process has spent on compiling kernels and on loading them from the cache.

    Garbage is not collected meanwhile: the collector would walk through a million short-lived objects in vain.
    `listener` is called with each kernel that Python calls, before it is compiled or loaded. `depth` is above zero
    while one is: those that it calls are compiled then, too.
    """

    def __init__(self) -> None:
        self.seconds, self.depth, self._began, self._collected = 0.0, 0, 0.0, False
        self.listener: Callable[[Any], None] | None = None

    def tell(self, kernel: Any) -> None:
        """Say that a kernel is about to be compiled or loaded; those inside it are not told apart."""
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
    """Dispatcher that treats literal arguments as plain numbers: a new literal triggers no compilation."""

    def compile(self, sig: Any) -> Any:
        """Called at the first call with arguments of new types."""
        COMPILATION.tell(self)
        with kernel_locked(self), COMPILATION:
            return super().compile(sig)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Called where another kernel calls this one."""
        return super().get_call_template([types.unliteral(argument) for argument in args], kws)


class _Inner(CPUDispatcher):
    """Compiled for kernels, without an entry from Python; called from there, an entry is compiled after all."""

    @cached_property
    def with_entry(self) -> Callable[..., Any]:
        """Give a compiled function an entry that Python can call."""
        return _dispatcher(Kernel, self.py_func, {**_ENTRY, **_COUNTED})

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.with_entry(*arguments, **named)


class _InnerKernel(_Inner, Kernel):
    """A kernel that Python and other kernels call."""


def section(function: Callable[..., Any]) -> Callable[..., Any]:
    """A part of one kernel under a name of its own: written into its callers, never compiled by itself."""
    return njit(inline="always", **_OPTIONS)(function)


@intrinsic
def _bits(typingctx: Any, x: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(types.int64))

    return types.int64(types.float64), codegen


@intrinsic
def _double(typingctx: Any, x: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(types.float64))

    return types.float64(types.int64), codegen


_LN2_HIGH = 0.6931471803691238  # upper 33 bits of ln 2: times any exponent it is exact
_LN2_LOW = float(np.longdouble("0.693147180559945309417232121458") - np.longdouble(_LN2_HIGH))
_LN2_INVERSE = 1.4426950408889634
_SQRT_HALF = 0.7071067811865476


@point
def log(x: float) -> float:
    """Natural logarithm for normal positive x; nan for the rest. Vectorises, unlike the C library's.

    x = 2^e m with m in [sqrt(1/2), sqrt(2)); log m = 2 artanh s, s = (m - 1)/(m + 1), whose series
    to s^21 is below half a unit in the last place because |s| < 0.1716.
    """
    bits = _bits(x)
    e = ((bits >> 52) & 0x7FF) - 1022
    m = _double((bits & 0x000FFFFFFFFFFFFF) | 0x3FE0000000000000)
    low = m < _SQRT_HALF
    m = 2.0 * m if low else m
    e = e - 1 if low else e
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    r = 2.0 / 21.0
    r = r * z + 2.0 / 19.0
    r = r * z + 2.0 / 17.0
    r = r * z + 2.0 / 15.0
    r = r * z + 2.0 / 13.0
    r = r * z + 2.0 / 11.0
    r = r * z + 2.0 / 9.0
    r = r * z + 2.0 / 7.0
    r = r * z + 2.0 / 5.0
    r = r * z + 2.0 / 3.0
    # 2 s = f - s f: keeps the leading digit exact near x = 1
    value = e * _LN2_HIGH + (f - (s * (f - z * r) - e * _LN2_LOW))
    return value if x > 0.0 else np.nan


@point
def exp(x: float) -> float:
    """Exponential for |x| < 700. Vectorises, unlike the C library's."""
    k = np.floor(x * _LN2_INVERSE + 0.5)
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    return p * _double((np.int64(k) + 1023) << 52)


@point
def power(x: float, exponent: float) -> float:
    """x**exponent for positive x."""
    return exp(exponent * log(x))
