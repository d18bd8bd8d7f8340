"""Numbers and dual numbers as LLVM holds them: components, and their sums, products and quotients."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.typeconv import Conversion
from numba.extending import models, register_model

__all__ = [
    "CHANGING", "DIRECTIONS", "DOUBLE", "INDEX", "LANES", "REGISTER", "TYPES", "Dual", "arithmetic_of", "combined",
    "components_of", "difference", "finished", "is_number", "negative", "pack", "pair", "product_of", "quotient",
    "total",
]  # fmt: skip

DIRECTIONS = (4, 8, 12)
LANES = 4
DOUBLE, REGISTER = ir.DoubleType(), ir.VectorType(ir.DoubleType(), LANES)
FUSED = ("contract",)
INDEX = ir.IntType(32)


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
        return Conversion.safe if is_number(other) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        """Return the type of a variable that is sometimes a number."""
        return self if is_number(other) else None


TYPES = {directions: Dual(directions) for directions in DIRECTIONS}
CHANGING = {directions: Dual(directions, changing=True) for directions in DIRECTIONS}


def is_number(found: Any) -> bool:
    """Return whether a type is a number without derivatives."""
    return isinstance(found, types.Float | types.Integer)


@register_model(Dual)
class _DualModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Dual) -> None:
        super().__init__(dmm, fe_type, _struct(fe_type))


def _struct(found: Dual) -> Any:
    return ir.LiteralStructType(([DOUBLE] + [REGISTER] * found.registers) * (1 + found.changing))


# --- components: a number is [value], a dual number [value, register, ...] -----------------------------------------
# each of a changing dual number is a pair: itself, and its change, None for zero


def pack(builder: Any, found: Dual, components: list[Any]) -> Any:
    """Return the dual number of these components."""
    out = ir.Constant(_struct(found), ir.Undefined)
    if found.changing:
        pairs = [pair(one) for one in components]
        components = [x for x, _ in pairs] + [ir.Constant(x.type, None) if dx is None else dx for x, dx in pairs]
    for i, component in enumerate(components):
        out = builder.insert_value(out, component, i)
    return out


def components_of(context: Any, builder: Any, found: Any, held: Any) -> list[Any]:
    """Return the components of a value of type `found`."""
    if not isinstance(found, Dual):
        return [context.cast(builder, held, found, types.float64)]
    count = 1 + found.registers
    parts = [builder.extract_value(held, i) for i in range(count * (1 + found.changing))]
    return list(zip(parts[:count], parts[count:], strict=True)) if found.changing else parts


def pair(component: Any) -> tuple[Any, Any]:
    """Return a component and its change."""
    return component if isinstance(component, tuple) else (component, None)


class _Changes:
    """The arithmetic of a builder for pairs: d(xy) = dx y + x dy."""

    def __init__(self, builder: Any) -> None:
        self.builder = builder

    def total(self, x: Any, y: Any) -> Any:
        return y if x is None else x if y is None else self.builder.fadd(x, y, flags=FUSED)

    def product(self, x: Any, y: Any) -> Any:
        return None if x is None else self.builder.fmul(x, y, flags=FUSED)

    def fneg(self, one: Any) -> Any:
        x, dx = pair(one)
        return self.builder.fneg(x), None if dx is None else self.builder.fneg(dx)

    def fadd(self, one: Any, other: Any, flags: Any = ()) -> Any:
        (x, dx), (y, dy) = pair(one), pair(other)
        return self.builder.fadd(x, y, flags=flags), self.total(dx, dy)

    def fsub(self, one: Any, other: Any, flags: Any = ()) -> Any:
        return self.fadd(one, self.fneg(other), flags)

    def fmul(self, one: Any, other: Any, flags: Any = ()) -> Any:
        (x, dx), (y, dy) = pair(one), pair(other)
        return self.builder.fmul(x, y, flags=flags), self.total(self.product(dx, y), self.product(dy, x))

    def fdiv(self, one: Any, other: Any, flags: Any = ()) -> Any:
        (x, dx), (y, dy) = pair(one), pair(other)
        found = self.builder.fdiv(x, y, flags=flags)
        change = self.total(dx, self.product(dy, self.builder.fneg(found)))
        return found, None if change is None else self.builder.fdiv(change, y, flags=flags)


def arithmetic_of(builder: Any, scalars: Iterable[Any]) -> Any:
    """Return a builder of products and sums of components of these types of numbers."""
    return _Changes(builder) if any(isinstance(one, Dual) and one.changing for one in scalars) else builder


def finished(builder: Any, found: Any, components: list[Any]) -> Any:
    """Return the value of a scalar of type `found`."""
    if not isinstance(found, Dual):
        return pair(components[0])[0]
    nothing = [ir.Constant(REGISTER, [0.0] * LANES)] * (1 + found.registers - len(components))
    return pack(builder, found, components + nothing)


def _spread(builder: Any, number: Any) -> Any:
    """Return a register of one number."""
    if isinstance(number, tuple):
        return tuple(None if part is None else _spread(builder, part) for part in number)
    builder = builder.builder if isinstance(builder, _Changes) else builder
    undefined = ir.Constant(REGISTER, ir.Undefined)
    first = builder.insert_element(undefined, number, INDEX(0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(INDEX, LANES), [0] * LANES))


def combined(builder: Any, a: Any, first: list[Any], b: Any, second: list[Any]) -> list[Any]:
    """Return a d(first) + b d(second), register by register."""
    one = _spread(builder, a) if len(first) > 1 else None
    other = _spread(builder, b) if len(second) > 1 else None
    out = []
    for i in range(1, max(len(first), len(second))):
        x = builder.fmul(first[i], one, flags=FUSED) if one is not None else None
        y = builder.fmul(second[i], other, flags=FUSED) if other is not None else None
        out.append(y if x is None else x if y is None else builder.fadd(x, y, flags=FUSED))
    return out


def total(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    """Return a + b."""
    both = [builder.fadd(x, y, flags=FUSED) for x, y in zip(a, b, strict=False)]
    return both + a[len(both) :] + b[len(both) :]


def negative(builder: Any, a: list[Any]) -> list[Any]:
    """Return -a."""
    return [builder.fneg(x) for x in a]


def difference(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    """Return a - b."""
    both = [builder.fsub(x, y, flags=FUSED) for x, y in zip(a, b, strict=False)]
    return both + a[len(both) :] + negative(builder, b[len(both) :])


def product_of(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    """Return a b."""
    return [builder.fmul(a[0], b[0], flags=FUSED), *combined(builder, b[0], a, a[0], b)]


def quotient(builder: Any, a: list[Any], b: list[Any]) -> list[Any]:
    """Return a / b."""
    found = builder.fdiv(a[0], b[0], flags=FUSED)
    if len(a) == len(b) == 1:
        return [found]
    inverse = builder.fdiv(ir.Constant(DOUBLE, 1.0), b[0], flags=FUSED)
    back = builder.fneg(builder.fmul(found, inverse, flags=FUSED))
    return [found, *combined(builder, inverse, a, back, b)]
