"""The functions of `contactlab.api.mathematics` inside kernels, for numbers and dual numbers. Imports numba."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from types import FunctionType
from typing import Any

from numba import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, signature
from numba.extending import infer_getattr, overload

from contactlab.api import mathematics
from contactlab.api.compiled import kernel as kernels
from contactlab.api.compiled.dual import Dual, follow, follow_two, inner, value
from contactlab.api.compiled.dual_components import is_number
from contactlab.api.tensors import Tensor, Vector

__all__ = ["exp", "log", "methods_of"]

_INLINED: Any = {"forceinline": True}
log, exp, power = kernels.log, kernels.exp, kernels.power


def _function(name: str, found: Callable[[float], float], slope: Callable[[float, float], float]) -> None:
    """Define a function of one number; `slope` is its derivative, from the number and the function's value there."""
    function = getattr(mathematics, name)

    def of_number(x: Any) -> Any:
        return found(x)

    def of_dual(x: Any) -> Any:
        at = inner(x)
        reached = function(at)
        return follow(reached, slope(at, reached), x)

    @overload(function, jit_options=_INLINED, strict=False)
    def typed(x: Any) -> Any:
        return of_dual if isinstance(x, Dual) else of_number if is_number(x) else None


def _compiled(*functions: Any) -> tuple[Any, ...]:
    return tuple(kernels.point(function) for function in functions)


_ONE: dict[str, tuple[Any, Any]] = {
    "sqrt": _compiled(lambda x: math.sqrt(x), lambda x, y: 0.5 / y),
    "exp": (exp, *_compiled(lambda x, y: y)),
    "log": (log, *_compiled(lambda x, y: 1.0 / x)),
    "sin": _compiled(lambda x: math.sin(x), lambda x, y: mathematics.cos(x)),
    "cos": _compiled(lambda x: math.cos(x), lambda x, y: -mathematics.sin(x)),
    "tan": _compiled(lambda x: math.tan(x), lambda x, y: 1.0 + y * y),
    "asin": _compiled(lambda x: math.asin(x), lambda x, y: 1.0 / mathematics.sqrt(1.0 - x * x)),
    "acos": _compiled(lambda x: math.acos(x), lambda x, y: -1.0 / mathematics.sqrt(1.0 - x * x)),
    "atan": _compiled(lambda x: math.atan(x), lambda x, y: 1.0 / (1.0 + x * x)),
    "sinh": _compiled(lambda x: math.sinh(x), lambda x, y: mathematics.cosh(x)),
    "cosh": _compiled(lambda x: math.cosh(x), lambda x, y: mathematics.sinh(x)),
    "tanh": _compiled(lambda x: math.tanh(x), lambda x, y: 1.0 - y * y),
}
for _name, (_found, _slope) in _ONE.items():
    _function(_name, _found, _slope)


def _two(function: Any, of_numbers: Any, of_duals: Any) -> None:
    """Define a function of two numbers, of which one or both may be dual."""

    @overload(function, jit_options=_INLINED, strict=False)
    def typed(x: Any, y: Any) -> Any:
        if not all(isinstance(one, Dual) or is_number(one) for one in (x, y)):
            return None
        return of_duals if isinstance(x, Dual) or isinstance(y, Dual) else of_numbers


def _hypot(x: Any, y: Any) -> Any:
    a, b = inner(x), inner(y)
    found = mathematics.sqrt(a * a + b * b)
    return follow_two(found, a / found, x, b / found, y)


def _atan2(x: Any, y: Any) -> Any:
    a, b = inner(x), inner(y)
    square = a * a + b * b
    return follow_two(mathematics.atan2(a, b), b / square, x, -a / square, y)


def _power(x: Any, y: Any) -> Any:
    a, b = inner(x), inner(y)
    found = mathematics.power(a, b)
    return follow_two(found, b * mathematics.power(a, b - 1.0), x, found * mathematics.log(a), y)


def _copysign(x: Any, y: Any) -> Any:
    return -x if (value(x) < 0.0) != (math.copysign(1.0, value(y)) < 0.0) else x


def _smaller(x: Any, y: Any) -> Any:
    return y if y < x else x


def _larger(x: Any, y: Any) -> Any:
    return y if y > x else x


_two(mathematics.hypot, lambda x, y: math.sqrt(x * x + y * y), _hypot)
_two(mathematics.atan2, lambda x, y: math.atan2(x, y), _atan2)
_two(mathematics.power, lambda x, y: x**y, _power)
_two(mathematics.copysign, lambda x, y: math.copysign(x, y), _copysign)
_two(mathematics.minimum, _smaller, _smaller)
_two(mathematics.maximum, _larger, _larger)


@overload(mathematics.where, jit_options=_INLINED, strict=False)
def _where(condition: Any, x: Any, y: Any) -> Any:
    return lambda condition, x, y: x if condition else y


@overload(mathematics.isnan, jit_options=_INLINED, strict=False)
def _isnan(x: Any) -> Any:
    return lambda x: math.isnan(value(x))


def _positive(x: Any) -> Any:
    return -x if x < 0.0 else x


@overload(mathematics.fabs, jit_options=_INLINED, strict=False)
def _fabs(x: Any) -> Any:
    return _positive if isinstance(x, Dual) else lambda x: math.fabs(x)


@overload(abs, jit_options=_INLINED, strict=False)
def _abs(x: Any) -> Any:
    return _positive if isinstance(x, Dual) else None


def _only_duals(function: Any, of_duals: Any) -> None:
    """Define dual numbers for one of Python's own functions, which knows numbers."""

    @overload(function, jit_options=_INLINED, strict=False)
    def typed(x: Any, y: Any) -> Any:
        one = isinstance(x, Dual) or isinstance(y, Dual)
        return of_duals if one and all(isinstance(z, Dual) or is_number(z) for z in (x, y)) else None


_only_duals(min, _smaller)
_only_duals(max, _larger)
_only_duals(operator.pow, _power)


# --- methods of the named tuples in formulas -------------------------------------------------------------

_METHODS: dict[tuple[type, str], type] = {}


def methods_of(kind: type) -> type:
    """Let kernels call the methods of a named tuple; a class decorator."""
    for name, function in vars(kind).items():
        if isinstance(function, FunctionType) and not name.startswith("_"):
            _METHODS[kind, name] = _call(f"{kind.__module__}.{kind.__qualname__}.{name}", kernels.point(function))
    return kind


def _call(name: str, compiled: Any) -> type:
    function: Any = types.Dispatcher(compiled)

    class Call(AbstractTemplate):
        key, kept = name, compiled  # a type does not keep the type of its argument

        def generic(self, args: Any, kws: Any) -> Any:
            found = function.get_call_type(self.context, (self.this, *args), kws)
            return signature(found.return_type, *found.args[1:], recvr=self.this)

    @lower_builtin(name, types.VarArg(types.Any))
    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        called = context.get_function(function, function.get_call_type(context.typing_context, sig.args, {}))
        context.add_linking_libs(getattr(called, "libs", ()))
        return called(builder, args)

    return Call


@infer_getattr
class _Methods(AttributeTemplate):
    key = types.BaseNamedTuple

    def generic_resolve(self, found: Any, name: str) -> Any:  # type: ignore[override]
        call = _METHODS.get((found.instance_class, name))
        return None if call is None else types.BoundFunction(type("Call", (call,), {"this": found}), found)


for _kind in (Vector, Tensor):
    methods_of(_kind)
