"""Dual numbers inside kernels: a value and its derivatives by 4, 8 or 12 directions. Imports numba when imported.

Four derivatives share a vector register, so an operation costs one instruction for the value and one to three
for all derivatives. Comparisons use values: at a kink the derivative is one-sided, on the side of the value.

A *changing* dual number also has the change of all of them along one further direction: second derivatives.

Arithmetic is defined for numbers, dual numbers, and the vectors and tensors of `contactlab.api.tensors` of either.
"""

from __future__ import annotations

import operator
from itertools import product
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic

from contactlab.api.compiled.dual_components import (
    CHANGING,
    DIRECTIONS,
    DOUBLE,
    INDEX,
    LANES,
    REGISTER,
    TYPES,
    Dual,
    arithmetic_of,
    combined,
    components_of,
    difference,
    finished,
    is_number,
    negative,
    pack,
    pair,
    product_of,
    quotient,
    total,
)
from contactlab.api.tensors import Tensor, Vector

__all__ = [
    "DIRECTIONS", "Dual", "changes", "constant", "derivatives", "follow", "follow_two", "inner", "seed",
    "seed_changing", "value",
]  # fmt: skip


@lower_cast(types.Float, Dual)
@lower_cast(types.Integer, Dual)
def _lifted(context: Any, builder: Any, number: Any, dual: Any, held: Any) -> Any:
    return finished(builder, dual, components_of(context, builder, number, held))


# --- results of operators: numbers, vectors and tensors --------------------------------------------------------


def _kind(found: Any) -> type | None:
    """Return float for a number or a dual number, `Vector`, `Tensor`, or None for anything else."""
    if is_number(found) or isinstance(found, Dual):
        return float
    if isinstance(found, types.BaseNamedTuple) and found.instance_class in (Vector, Tensor):
        return found.instance_class if all(_kind(one) is float for one in found.types) else None
    return None


def _scalars(found: Any) -> tuple[Any, ...]:
    return tuple(found.types) if isinstance(found, types.BaseNamedTuple) else (found,)


def _scalar(found: tuple[Any, ...]) -> Any:
    """Return the type of a result of numbers of these types; None if their directions differ."""
    duals = {one for one in found if isinstance(one, Dual)}
    return types.float64 if not duals else duals.pop() if len(duals) == 1 else None


def _type(kind: type, scalar: Any) -> Any:
    return scalar if kind is float else types.BaseTuple.from_types((scalar,) * len(kind._fields), kind)


# the kind of the result by the kinds of the operands
_SAME = {(float, float): float, (Vector, Vector): Vector, (Tensor, Tensor): Tensor}
_SCALED = {(float, Vector): Vector, (float, Tensor): Tensor, (Vector, float): Vector, (Tensor, float): Tensor}
_RESULT: dict[Any, dict[tuple[type, type], type]] = {
    operator.add: _SAME,
    operator.sub: _SAME,
    operator.mul: {(float, float): float} | _SCALED,
    operator.truediv: {(float, float): float, (Vector, float): Vector, (Tensor, float): Tensor},
    operator.matmul: {(Tensor, Tensor): Tensor, (Tensor, Vector): Vector, (Vector, Vector): float},
}
_RESULT |= {
    operator.iadd: _RESULT[operator.add],
    operator.isub: _RESULT[operator.sub],
    operator.imul: _RESULT[operator.mul],
    operator.itruediv: _RESULT[operator.truediv],
}


def _matrix_product(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    """Return products of components: for vectors their dot product; tensors have rows xx, xy, yx, yy, zz."""

    def dot(i: int, j: int, k: int, m: int) -> list[Any]:
        return total(builder, product_of(builder, a[i], b[j]), product_of(builder, a[k], b[m]))

    if len(a) == 2:
        return [dot(0, 0, 1, 1)]
    if len(b) == 2:
        return [dot(0, 0, 1, 1), dot(2, 0, 3, 1)]
    plane = [dot(0, 0, 1, 2), dot(0, 1, 1, 3), dot(2, 0, 3, 2), dot(2, 1, 3, 3)]
    return [*plane, product_of(builder, a[4], b[4])]


_ELEMENT = {
    operator.add: total, operator.sub: difference, operator.mul: product_of, operator.truediv: quotient,
    operator.iadd: total, operator.isub: difference, operator.imul: product_of, operator.itruediv: quotient,
}  # fmt: skip

_DIVISIONS = (operator.truediv, operator.itruediv)


def _define(symbol: Any) -> None:
    class Template(AbstractTemplate):
        key = symbol

        def generic(self, args: Any, kws: Any) -> Any:
            if len(args) != 2 or (is_number(args[0]) and is_number(args[1])):
                return None
            result = _RESULT[symbol].get((_kind(args[0]), _kind(args[1])))  # type: ignore[arg-type]
            scalar = _scalar(_scalars(args[0]) + _scalars(args[1])) if result is not None else None
            return None if scalar is None else signature(_type(result, scalar), *args)  # type: ignore[arg-type]

    infer_global(symbol)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        sides = []
        for found, held in zip(sig.args, args, strict=True):
            if isinstance(found, types.BaseNamedTuple):
                held = [builder.extract_value(held, i) for i in range(len(found.types))]
                parts = zip(found.types, held, strict=True)
                sides.append([components_of(context, builder, kind, one) for kind, one in parts])
            else:
                sides.append([components_of(context, builder, found, held)])
        arithmetic = arithmetic_of(builder, [one for each in sig.args for one in _scalars(each)])
        if symbol is operator.matmul:
            made = _matrix_product(arithmetic, *sides)
        else:
            if symbol in _DIVISIONS and len(sides[0]) > 1:  # one division for all components
                sides[1] = [quotient(arithmetic, [ir.Constant(DOUBLE, 1.0)], sides[1][0])]
            most = max(map(len, sides))
            first, second = (side * (most // len(side)) for side in sides)
            element = product_of if symbol in _DIVISIONS and most > 1 else _ELEMENT[symbol]
            made = [element(arithmetic, a, b) for a, b in zip(first, second, strict=True)]
        return _result(context, builder, sig.return_type, made)

    for kinds in product((Dual, types.Float, types.Integer, types.BaseNamedTuple), repeat=2):
        if Dual in kinds or types.BaseNamedTuple in kinds:
            lower_builtin(symbol, *kinds)(lower)


def _result(context: Any, builder: Any, found: Any, made: list[list[Any]]) -> Any:
    held = [finished(builder, one, each) for one, each in zip(_scalars(found), made, strict=True)]
    return context.make_tuple(builder, found, held) if isinstance(found, types.BaseNamedTuple) else held[0]


for _symbol in _RESULT:
    _define(_symbol)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    key = operator.neg

    def generic(self, args: Any, kws: Any) -> Any:
        return None if is_number(args[0]) or _kind(args[0]) is None else signature(args[0], args[0])


@lower_builtin(operator.neg, Dual)
@lower_builtin(operator.neg, types.BaseNamedTuple)
def _lower_negative(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    found = sig.args[0]
    many = isinstance(found, types.BaseNamedTuple)
    held = [builder.extract_value(args[0], i) for i in range(len(found.types))] if many else [args[0]]
    parts = [components_of(context, builder, kind, one) for kind, one in zip(_scalars(found), held, strict=True)]
    arithmetic = arithmetic_of(builder, _scalars(found))
    return _result(context, builder, found, [negative(arithmetic, one) for one in parts])


def _define_comparison(symbol: Any, sign: str) -> None:
    class Template(AbstractTemplate):
        key = symbol

        def generic(self, args: Any, kws: Any) -> Any:
            dual = any(isinstance(one, Dual) for one in args)
            return signature(types.boolean, *args) if dual and all(_kind(one) is float for one in args) else None

    infer_global(symbol)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (pair(components_of(context, builder, *one)[0])[0] for one in zip(sig.args, args, strict=True))
        return builder.fcmp_unordered(sign, a, b) if sign == "!=" else builder.fcmp_ordered(sign, a, b)

    for kinds in product((Dual, types.Float, types.Integer), repeat=2):
        if Dual in kinds:
            lower_builtin(symbol, *kinds)(lower)


for _symbol, _sign in (
    (operator.lt, "<"), (operator.gt, ">"), (operator.le, "<="), (operator.ge, ">="), (operator.eq, "=="),
    (operator.ne, "!="),
):  # fmt: skip
    _define_comparison(_symbol, _sign)


# --- in and out of dual numbers ------------------------------------------------------------------------------------


def _value_of(x: Any) -> Any:
    """Return signature and code of the value of a number or a dual number."""
    if isinstance(x, Dual):
        return types.float64(x), lambda context, builder, sig, args: builder.extract_value(args[0], 0)
    return x(x), lambda context, builder, sig, args: args[0]


def _registers(x: Any, directions: Any, there: bool, first: int) -> Any:
    """Return signature and code of numbers in the registers of x from component `first` on; zeros if not `there`."""
    count = directions.literal_value
    found = types.UniTuple(types.float64, count)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if not there:
            return context.make_tuple(builder, found, [ir.Constant(DOUBLE, 0.0)] * count)
        out = []
        for number in range(count):
            register = builder.extract_value(args[0], first + number // LANES)
            out.append(builder.extract_element(register, INDEX(number % LANES)))
        return context.make_tuple(builder, found, out)

    return found(x, directions), codegen


def _unit(found: Dual, direction: Any) -> list[Any]:
    """Return registers of the derivatives of a direction itself."""
    unit = [float(i == direction.literal_value) for i in range(found.directions)]
    return [ir.Constant(REGISTER, unit[i : i + LANES]) for i in range(0, found.directions, LANES)]


@intrinsic
def value(typingctx: Any, x: Any) -> Any:
    """Return the value of a number or a dual number."""
    return _value_of(x)


@intrinsic
def inner(typingctx: Any, x: Any) -> Any:
    """Return the value of a number or a dual number; of a changing one its value and change, a dual number of 4."""
    if not (isinstance(x, Dual) and x.changing):
        return _value_of(x)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        change = builder.extract_value(args[0], 1 + x.registers)
        register = builder.insert_element(ir.Constant(REGISTER, [0.0] * LANES), change, INDEX(0))
        return pack(builder, TYPES[LANES], [builder.extract_value(args[0], 0), register])

    return TYPES[LANES](x), codegen


@intrinsic(prefer_literal=True)
def derivatives(typingctx: Any, x: Any, directions: Any) -> Any:
    """Return the derivatives of x by the first `directions`, a constant: a tuple; zeros for a number."""
    return _registers(x, directions, isinstance(x, Dual), 1)


@intrinsic(prefer_literal=True)
def changes(typingctx: Any, x: Any, directions: Any) -> Any:
    """Return the changes of the derivatives by the first `directions`, a constant: a tuple; zeros for other numbers."""
    changing = isinstance(x, Dual) and x.changing
    return _registers(x, directions, changing, 2 + x.registers if changing else 0)


@intrinsic(prefer_literal=True)
def seed(typingctx: Any, x: Any, direction: Any, directions: Any) -> Any:
    """Return the dual number of value x that is one of the `directions` itself; both are constants."""
    found = TYPES[directions.literal_value]

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return pack(builder, found, [context.cast(builder, args[0], x, types.float64), *_unit(found, direction)])

    return found(x, direction, directions), codegen


@intrinsic(prefer_literal=True)
def seed_changing(typingctx: Any, x: Any, direction: Any, directions: Any, change: Any) -> Any:
    """Return `seed` of the first three arguments as a changing dual number, which changes by `change`."""
    found = CHANGING[directions.literal_value]

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = context.cast(builder, args[0], x, types.float64)
        moved = context.cast(builder, args[3], change, types.float64)
        return pack(builder, found, [(at, moved), *_unit(found, direction)])

    return found(x, direction, directions, change), codegen


@intrinsic(prefer_literal=True)
def constant(typingctx: Any, x: Any, directions: Any) -> Any:
    """Return the dual number of value x that changes in none of the `directions`, a constant."""
    found = TYPES[directions.literal_value]
    return found(x, directions), lambda context, builder, sig, args: finished(
        builder, found, components_of(context, builder, x, args[0])
    )


def _inner_component(builder: Any, found: Any, held: Any) -> Any:
    """Return the component that a number makes, or the dual number of 4 that `inner` returns."""
    if not isinstance(found, Dual):
        return held
    register = builder.extract_value(held, 1)
    return builder.extract_value(held, 0), builder.extract_element(register, INDEX(0))


@intrinsic
def follow(typingctx: Any, found: Any, slope: Any, x: Any) -> Any:
    """Return the dual number of value `found` that changes by `slope` times the change of x.

    Value and slope are functions of `inner(x)`.
    """

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, by = (_inner_component(builder, *one) for one in zip(sig.args[:2], args[:2], strict=True))
        components = components_of(context, builder, x, args[2])
        return pack(builder, x, [value, *combined(arithmetic_of(builder, (x,)), by, components, None, [None])])

    return x(found, slope, x), codegen


@intrinsic
def follow_two(typingctx: Any, found: Any, slope: Any, x: Any, other: Any, y: Any) -> Any:
    """Return the dual number of value `found` that changes by `slope` times x's plus `other` times y's change."""
    result = _scalar((x, y))

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, one, two = (_inner_component(builder, sig.args[i], args[i]) for i in (0, 1, 3))
        first, second = components_of(context, builder, x, args[2]), components_of(context, builder, y, args[4])
        return pack(builder, result, [value, *combined(arithmetic_of(builder, (x, y)), one, first, two, second)])

    return result(found, slope, x, other, y), codegen
