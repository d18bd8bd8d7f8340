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
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

from contactlab.api.tensors import Tensor, Vector

__all__ = [
    "DIRECTIONS", "Dual", "changes", "constant", "derivatives", "follow", "follow_two", "inner", "seed",
    "seed_changing", "value",
]  # fmt: skip

DIRECTIONS = (4, 8, 12)
LANES = 4
_DOUBLE, _REGISTER = ir.DoubleType(), ir.VectorType(ir.DoubleType(), LANES)
_FUSED = ("contract",)
_I32 = ir.IntType(32)


class Dual(types.Type):
    """The type of a dual number with a given number of directions."""

    def __init__(self, directions: int, changing: bool = False) -> None:
        self.directions, self.changing = directions, changing
        super().__init__(f"{'changing ' if changing else ''}dual number with {directions} directions")

    @property
    def registers(self) -> int:
        """Number of vectors of four derivatives."""
        return self.directions // LANES

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """Treat a number as a dual number without derivatives."""
        return Conversion.safe if _is_number(other) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        """Return the type of a variable that is sometimes a number."""
        return self if _is_number(other) else None


_TYPES = {directions: Dual(directions) for directions in DIRECTIONS}
_CHANGING = {directions: Dual(directions, changing=True) for directions in DIRECTIONS}


def _is_number(found: Any) -> bool:
    return isinstance(found, types.Float | types.Integer)


@register_model(Dual)
class _DualModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Dual) -> None:
        super().__init__(dmm, fe_type, _struct(fe_type))


def _struct(found: Dual) -> Any:
    return ir.LiteralStructType(([_DOUBLE] + [_REGISTER] * found.registers) * (1 + found.changing))


# --- components: a number is [value], a dual number [value, register, ...] -----------------------------------------
# each of a changing dual number is a pair: itself, and its change, None for zero


def _pack(builder: Any, found: Dual, components: list[Any]) -> Any:
    out = ir.Constant(_struct(found), ir.Undefined)
    if found.changing:
        pairs = [_pair(one) for one in components]
        components = [x for x, _ in pairs] + [ir.Constant(x.type, None) if dx is None else dx for x, dx in pairs]
    for i, component in enumerate(components):
        out = builder.insert_value(out, component, i)
    return out


def _components(context: Any, builder: Any, found: Any, held: Any) -> list[Any]:
    if not isinstance(found, Dual):
        return [context.cast(builder, held, found, types.float64)]
    count = 1 + found.registers
    parts = [builder.extract_value(held, i) for i in range(count * (1 + found.changing))]
    return list(zip(parts[:count], parts[count:], strict=True)) if found.changing else parts


def _pair(component: Any) -> tuple[Any, Any]:
    return component if isinstance(component, tuple) else (component, None)


class _Changes:
    """The arithmetic of a builder for pairs: d(xy) = dx y + x dy."""

    def __init__(self, builder: Any) -> None:
        self.builder = builder
        self.insert_element, self.shuffle_vector = builder.insert_element, builder.shuffle_vector
        self.insert_value = builder.insert_value

    def _sum(self, x: Any, y: Any) -> Any:
        return y if x is None else x if y is None else self.builder.fadd(x, y, flags=_FUSED)

    def _product(self, x: Any, y: Any) -> Any:
        return None if x is None else self.builder.fmul(x, y, flags=_FUSED)

    def fneg(self, one: Any) -> Any:
        x, dx = _pair(one)
        return self.builder.fneg(x), None if dx is None else self.builder.fneg(dx)

    def fadd(self, one: Any, other: Any, flags: Any = ()) -> Any:
        (x, dx), (y, dy) = _pair(one), _pair(other)
        return self.builder.fadd(x, y, flags=flags), self._sum(dx, dy)

    def fsub(self, one: Any, other: Any, flags: Any = ()) -> Any:
        return self.fadd(one, self.fneg(other), flags)

    def fmul(self, one: Any, other: Any, flags: Any = ()) -> Any:
        (x, dx), (y, dy) = _pair(one), _pair(other)
        return self.builder.fmul(x, y, flags=flags), self._sum(self._product(dx, y), self._product(dy, x))

    def fdiv(self, one: Any, other: Any, flags: Any = ()) -> Any:
        (x, dx), (y, dy) = _pair(one), _pair(other)
        found = self.builder.fdiv(x, y, flags=flags)
        change = self._sum(dx, self._product(dy, self.builder.fneg(found)))
        return found, None if change is None else self.builder.fdiv(change, y, flags=flags)


def _arithmetic(builder: Any, *found: Any) -> Any:
    """Return a builder of products and sums of components of these types."""
    scalars = [one for each in found for one in _scalars(each)]
    return _Changes(builder) if any(isinstance(one, Dual) and one.changing for one in scalars) else builder


def _finished(builder: Any, found: Any, components: list[Any]) -> Any:
    """Return the value of a scalar of type `found`."""
    if not isinstance(found, Dual):
        return _pair(components[0])[0]
    nothing = [ir.Constant(_REGISTER, [0.0] * LANES)] * (1 + found.registers - len(components))
    return _pack(builder, found, components + nothing)


def _spread(builder: Any, number: Any) -> Any:
    """Return a register of one number."""
    if isinstance(number, tuple):
        return tuple(None if part is None else _spread(builder, part) for part in number)
    undefined = ir.Constant(_REGISTER, ir.Undefined)
    first = builder.insert_element(undefined, number, _I32(0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(_I32, LANES), [0] * LANES))


def _combined(builder: Any, a: Any, first: list[Any], b: Any, second: list[Any]) -> list[Any]:
    """Return a d(first) + b d(second), register by register."""
    one = _spread(builder, a) if len(first) > 1 else None
    other = _spread(builder, b) if len(second) > 1 else None
    out = []
    for i in range(1, max(len(first), len(second))):
        x = builder.fmul(first[i], one, flags=_FUSED) if one is not None else None
        y = builder.fmul(second[i], other, flags=_FUSED) if other is not None else None
        out.append(y if x is None else x if y is None else builder.fadd(x, y, flags=_FUSED))
    return out


def _sum(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    both = [builder.fadd(x, y, flags=_FUSED) for x, y in zip(a, b, strict=False)]
    return both + a[len(both) :] + b[len(both) :]


def _negative(builder: Any, a: list[Any]) -> list[Any]:
    return [builder.fneg(x) for x in a]


def _difference(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    both = [builder.fsub(x, y, flags=_FUSED) for x, y in zip(a, b, strict=False)]
    return both + a[len(both) :] + _negative(builder, b[len(both) :])


def _product(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    return [builder.fmul(a[0], b[0], flags=_FUSED), *_combined(builder, b[0], a, a[0], b)]


def _quotient(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    found = builder.fdiv(a[0], b[0], flags=_FUSED)
    if len(a) == len(b) == 1:
        return [found]
    inverse = builder.fdiv(ir.Constant(_DOUBLE, 1.0), b[0], flags=_FUSED)
    back = builder.fneg(builder.fmul(found, inverse, flags=_FUSED))
    return [found, *_combined(builder, inverse, a, back, b)]


@lower_cast(types.Float, Dual)
@lower_cast(types.Integer, Dual)
def _lifted(context: Any, builder: Any, number: Any, dual: Any, held: Any) -> Any:
    return _finished(builder, dual, _components(context, builder, number, held))


# --- results of operators: numbers, vectors and tensors --------------------------------------------------------


def _kind(found: Any) -> type | None:
    """Return float for a number or a dual number, `Vector`, `Tensor`, or None for anything else."""
    if _is_number(found) or isinstance(found, Dual):
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
        return _sum(builder, _product(builder, a[i], b[j]), _product(builder, a[k], b[m]))

    if len(a) == 2:
        return [dot(0, 0, 1, 1)]
    if len(b) == 2:
        return [dot(0, 0, 1, 1), dot(2, 0, 3, 1)]
    plane = [dot(0, 0, 1, 2), dot(0, 1, 1, 3), dot(2, 0, 3, 2), dot(2, 1, 3, 3)]
    return [*plane, _product(builder, a[4], b[4])]


_ELEMENT = {
    operator.add: _sum, operator.sub: _difference, operator.mul: _product, operator.truediv: _quotient,
    operator.iadd: _sum, operator.isub: _difference, operator.imul: _product, operator.itruediv: _quotient,
}  # fmt: skip

_DIVISIONS = (operator.truediv, operator.itruediv)


def _define(symbol: Any) -> None:
    class Template(AbstractTemplate):
        key = symbol

        def generic(self, args: Any, kws: Any) -> Any:
            if len(args) != 2 or (_is_number(args[0]) and _is_number(args[1])):
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
                sides.append([_components(context, builder, kind, one) for kind, one in parts])
            else:
                sides.append([_components(context, builder, found, held)])
        arithmetic = _arithmetic(builder, *sig.args)
        if symbol is operator.matmul:
            made = _matrix_product(arithmetic, *sides)
        else:
            if symbol in _DIVISIONS and len(sides[0]) > 1:  # one division for all components
                sides[1] = [_quotient(arithmetic, [ir.Constant(_DOUBLE, 1.0)], sides[1][0])]
            most = max(map(len, sides))
            first, second = (side * (most // len(side)) for side in sides)
            element = _product if symbol in _DIVISIONS and most > 1 else _ELEMENT[symbol]
            made = [element(arithmetic, a, b) for a, b in zip(first, second, strict=True)]
        return _result(context, builder, sig.return_type, made)

    for kinds in product((Dual, types.Float, types.Integer, types.BaseNamedTuple), repeat=2):
        if Dual in kinds or types.BaseNamedTuple in kinds:
            lower_builtin(symbol, *kinds)(lower)


def _result(context: Any, builder: Any, found: Any, made: list[list[Any]]) -> Any:
    held = [_finished(builder, one, each) for one, each in zip(_scalars(found), made, strict=True)]
    return context.make_tuple(builder, found, held) if isinstance(found, types.BaseNamedTuple) else held[0]


for _symbol in _RESULT:
    _define(_symbol)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    key = operator.neg

    def generic(self, args: Any, kws: Any) -> Any:
        return None if _is_number(args[0]) or _kind(args[0]) is None else signature(args[0], args[0])


@lower_builtin(operator.neg, Dual)
@lower_builtin(operator.neg, types.BaseNamedTuple)
def _lower_negative(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    found = sig.args[0]
    many = isinstance(found, types.BaseNamedTuple)
    held = [builder.extract_value(args[0], i) for i in range(len(found.types))] if many else [args[0]]
    parts = [_components(context, builder, kind, one) for kind, one in zip(_scalars(found), held, strict=True)]
    arithmetic = _arithmetic(builder, found)
    return _result(context, builder, found, [_negative(arithmetic, one) for one in parts])


def _define_comparison(symbol: Any, sign: str) -> None:
    class Template(AbstractTemplate):
        key = symbol

        def generic(self, args: Any, kws: Any) -> Any:
            dual = any(isinstance(one, Dual) for one in args)
            return signature(types.boolean, *args) if dual and all(_kind(one) is float for one in args) else None

    infer_global(symbol)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (_pair(_components(context, builder, *one)[0])[0] for one in zip(sig.args, args, strict=True))
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


@intrinsic
def value(typingctx: Any, x: Any) -> Any:
    """Return the value of a number or a dual number."""
    if isinstance(x, Dual):
        return types.float64(x), lambda context, builder, sig, args: builder.extract_value(args[0], 0)
    return x(x), lambda context, builder, sig, args: args[0]


@intrinsic(prefer_literal=True)
def derivatives(typingctx: Any, x: Any, directions: Any) -> Any:
    """Return the derivatives of x by the first `directions`, a constant: a tuple; zeros for a number."""
    count = directions.literal_value
    found = types.UniTuple(types.float64, count)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if not isinstance(x, Dual):
            return context.make_tuple(builder, found, [ir.Constant(_DOUBLE, 0.0)] * count)
        out = []
        for number in range(count):
            register = builder.extract_value(args[0], 1 + number // LANES)
            out.append(builder.extract_element(register, _I32(number % LANES)))
        return context.make_tuple(builder, found, out)

    return found(x, directions), codegen


@intrinsic(prefer_literal=True)
def seed(typingctx: Any, x: Any, direction: Any, directions: Any) -> Any:
    """Return the dual number of value x that is one of the `directions` itself; both are constants."""
    found, number = _TYPES[directions.literal_value], direction.literal_value

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        unit = [float(i == number) for i in range(found.directions)]
        registers = [ir.Constant(_REGISTER, unit[i : i + LANES]) for i in range(0, found.directions, LANES)]
        return _pack(builder, found, [context.cast(builder, args[0], x, types.float64), *registers])

    return found(x, direction, directions), codegen


@intrinsic(prefer_literal=True)
def constant(typingctx: Any, x: Any, directions: Any) -> Any:
    """Return the dual number of value x that changes in none of the `directions`, a constant."""
    found = _TYPES[directions.literal_value]
    return found(x, directions), lambda context, builder, sig, args: _finished(
        builder, found, _components(context, builder, x, args[0])
    )


@intrinsic
def inner(typingctx: Any, x: Any) -> Any:
    """Return the value of a number or a dual number; of a changing one its value and change, a dual number of 4."""
    if not (isinstance(x, Dual) and x.changing):
        number = types.float64 if isinstance(x, Dual) else x
        return number(
            x
        ), lambda context, builder, sig, args: builder.extract_value(args[0], 0) if isinstance(x, Dual) else args[0]

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        change = builder.extract_value(args[0], 1 + x.registers)
        register = builder.insert_element(ir.Constant(_REGISTER, [0.0] * LANES), change, _I32(0))
        return _pack(builder, _TYPES[LANES], [builder.extract_value(args[0], 0), register])

    return _TYPES[LANES](x), codegen


@intrinsic(prefer_literal=True)
def seed_changing(typingctx: Any, x: Any, direction: Any, directions: Any, change: Any) -> Any:
    """Return `seed` of the first three arguments as a changing dual number, which changes by `change`."""
    found, number = _CHANGING[directions.literal_value], direction.literal_value

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        unit = [float(i == number) for i in range(found.directions)]
        registers = [ir.Constant(_REGISTER, unit[i : i + LANES]) for i in range(0, found.directions, LANES)]
        at, moved = (
            context.cast(builder, args[i], (x, direction, directions, change)[i], types.float64) for i in (0, 3)
        )
        return _pack(builder, found, [(at, moved), *registers])

    return found(x, direction, directions, change), codegen


@intrinsic(prefer_literal=True)
def changes(typingctx: Any, x: Any, directions: Any) -> Any:
    """Return the changes of the derivatives by the first `directions`, a constant: a tuple; zeros for other numbers."""
    count = directions.literal_value
    found = types.UniTuple(types.float64, count)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if not (isinstance(x, Dual) and x.changing):
            return context.make_tuple(builder, found, [ir.Constant(_DOUBLE, 0.0)] * count)
        out = []
        for number in range(count):
            register = builder.extract_value(args[0], 2 + x.registers + number // LANES)
            out.append(builder.extract_element(register, _I32(number % LANES)))
        return context.make_tuple(builder, found, out)

    return found(x, directions), codegen


def _inner_component(builder: Any, found: Any, held: Any) -> Any:
    """Return the component that a number makes, or the dual number of 4 that `inner` returns."""
    if not isinstance(found, Dual):
        return held
    register = builder.extract_value(held, 1)
    return builder.extract_value(held, 0), builder.extract_element(register, _I32(0))


@intrinsic
def follow(typingctx: Any, found: Any, slope: Any, x: Any) -> Any:
    """Return the dual number of value `found` that changes by `slope` times the change of x.

    Value and slope are functions of `inner(x)`.
    """

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, by = (_inner_component(builder, *one) for one in zip(sig.args[:2], args[:2], strict=True))
        components = _components(context, builder, x, args[2])
        return _pack(builder, x, [value, *_combined(_arithmetic(builder, x), by, components, None, [None])])

    return x(found, slope, x), codegen


@intrinsic
def follow_two(typingctx: Any, found: Any, slope: Any, x: Any, other: Any, y: Any) -> Any:
    """Return the dual number of value `found` that changes by `slope` times x's plus `other` times y's change."""
    result = _scalar((x, y))

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, one, two = (_inner_component(builder, sig.args[i], args[i]) for i in (0, 1, 3))
        first, second = _components(context, builder, x, args[2]), _components(context, builder, y, args[4])
        return _pack(builder, result, [value, *_combined(_arithmetic(builder, x, y), one, first, two, second)])

    return result(found, slope, x, other, y), codegen
