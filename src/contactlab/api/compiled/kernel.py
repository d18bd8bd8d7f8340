"""The decorators for compiled kernels, and the scalar functions that vectorise.

Kernels take contiguous arrays, write into the given outputs and allocate nothing.

`kernel`  for loops over blocks of cells or nodes. A division by zero gives inf or NaN as in NumPy (a check would
          prevent vectorisation); multiply-add contraction is allowed, reassociation is not, so results do not
          depend on the block size; the interpreter lock is released; machine code is cached on disk. A kernel
          whose name begins with an underscore is called by other kernels only.
`table_kernel`  for kernels on the arrays of a table (`unpack`). They do not count references to arrays and cannot
          create any. Whoever bound the arrays keeps them alive.
`point`   for functions of a single point that kernels call: always inlined.
`section` for parts of a long kernel: always inlined, too.

Code called by a kernel is compiled within it and never by itself: points, sections, and its own copy of other kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import intrinsic

from contactlab.api.compiled.cache import cache_folder
from contactlab.api.compiled.compiler import COUNTED, OPTIONS, Inlined, Kernel, Part, dispatcher

__all__ = ["exp", "kernel", "log", "point", "power", "section", "summation", "table_kernel"]


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a block kernel with the options that this module's docstring lists."""
    return _compiled(function, COUNTED)


def table_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a block kernel that counts no references to arrays. numba refuses a kernel that creates an array."""
    return _compiled(function, {**OPTIONS, "_nrt": False})


def formula_kernel(kind: type[Kernel], function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel of a class derived from `Kernel`."""
    return _compiled(function, COUNTED, kind)


def summation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel whose sums may be taken in any order, as wide as the processor can add.

    Its last digits depend on the processor: only for numbers that are shown, never for numbers of a run.
    """
    return _compiled(function, {**COUNTED, "fastmath": {"contract", "reassoc"}})


def point(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of a single point, inlined into every kernel that calls it."""
    return dispatcher(Inlined, function, COUNTED)


def section(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a part of a long kernel, inlined into it like a `point`."""
    return point(function)


def _compiled(
    function: Callable[..., Any], options: dict[str, Any], kind: type[Kernel] | None = None
) -> Callable[..., Any]:
    if function.__name__.startswith("_"):
        return dispatcher(Part, function, options)
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_folder(function.__code__.co_filename)
    try:
        return dispatcher(kind or Kernel, function, options, cached=True)
    finally:
        numba.config.CACHE_DIR = before


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
    """Return the natural logarithm of positive normal x, NaN otherwise. Vectorises, unlike the C library's.

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
    """Return the exponential for |x| < 700. Vectorises, unlike the C library's."""
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
    """Return x**exponent for positive x."""
    return exp(exponent * log(x))
