"""The arrays of a `BoundArrays` inside a kernel. Imports numba when it is imported.

A table is an address there, and a field of it an array that is read from the table when it is named. As a tuple of all
its arrays a table of twenty would be a value of 150 words, which every statement that names it copies and takes apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import from_dtype, types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import NativeValue, infer_getattr, intrinsic, lower_getattr_generic, models, register_model, unbox

from contactlab.api.compiled.bound_arrays import ADDRESS_BITS, DTYPES, layout_of, members

__all__ = ["unpack"]

STALE = "bound arrays: their BoundArrays object is gone; keep it as long as its address is used"
HEAD = 5
"""Number of words of an array before its shape: owner, parent, size, bytes per entry, address."""
WORD = ir.IntType(64)


class Table(types.Type):
    """The type of a table inside a kernel: the address of its first array."""

    def __init__(self, table: type) -> None:
        self.table = table
        super().__init__(f"{table.__module__}.{table.__qualname__}")

    @property
    def key(self) -> type:
        """Key of the type: tables of one class are of one type, which is all that numba has to compare."""
        return self.table


@register_model(Table)
class _TableModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, WORD.as_pointer())


@unbox(Table)
def _argument(kind: Any, given: Any, c: Any) -> Any:
    """Return the table of a `KernelArgument`, which keeps its arrays while the kernel runs."""
    bound = c.pyapi.object_getattr_string(given, "packed")
    number = c.pyapi.object_getattr_string(bound, "address")
    address = c.pyapi.long_as_longlong(number)
    c.pyapi.decref(number)
    c.pyapi.decref(bound)
    return NativeValue(c.builder.gep(_place(c.builder, address), [WORD(1)]))


@infer_getattr
class _TableFields(AttributeTemplate):
    key = Table

    def generic_resolve(self, table: Any, name: str) -> Any:  # type: ignore[override]
        held = members(table.table).get(name)
        if held is None:
            return None  # numba says that there is no such field
        return _array(held) if isinstance(held, str) else Table(held)


@lower_getattr_generic(Table)
def _field(context: Any, builder: Any, table: Any, value: Any, name: str) -> Any:
    held = members(table.table)
    before = list(held)[: list(held).index(name)]
    words = sum(_words(word) for field in before for word in _layout(held[field]).split())
    place, found = builder.gep(value, [WORD(words)]), held[name]
    return _load(context, builder, found, place) if isinstance(found, str) else place


@intrinsic(prefer_literal=True)
def unpack(typingctx: Any, address: Any, layout: Any) -> Any:
    """Return the arrays bound at `address`, as a tuple; with names if `layout`, a constant, is a table.

    `layout` must be the layout at binding. Raises ValueError if their `BoundArrays` object is gone.
    """
    found = _type_of(layout)
    if found is None:
        return None

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _place(builder, args[0])
        alive = builder.load(place)
        with builder.if_then(builder.icmp_unsigned("!=", alive, args[0]), likely=False):
            context.call_conv.return_user_exc(builder, ValueError, (STALE,))
        place = builder.gep(place, [WORD(1)])
        if isinstance(found, Table):
            return place
        arrays = []
        for word in layout.literal_value.split():
            arrays.append(_load(context, builder, word, place))
            place = builder.gep(place, [WORD(_words(word))])
        return context.make_tuple(builder, found, arrays)

    return found(types.int64, layout), codegen


def _place(builder: Any, address: Any) -> Any:
    return builder.inttoptr(builder.and_(address, WORD((1 << ADDRESS_BITS) - 1)), WORD.as_pointer())


def _type_of(layout: Any) -> Any:
    if isinstance(layout, types.StringLiteral):
        return types.BaseTuple.from_types(tuple(_array(word) for word in layout.literal_value.split()))
    if isinstance(layout, types.TypeRef):
        return layout.instance_type
    return Table(layout.instance_class) if isinstance(layout, types.NamedTupleClass) else None


def _layout(held: str | type) -> str:
    return held if isinstance(held, str) else layout_of(held)


def _words(word: str) -> int:
    return HEAD + 2 * int(word[1])


def _array(word: str) -> Any:
    return types.Array(from_dtype(np.dtype(DTYPES[word[0]])), int(word[1]), "C")


def _load(context: Any, builder: Any, word: str, place: Any) -> Any:
    """Return the array at a place of a table. It has no owner: its binder keeps it, so references are not counted."""

    def read(number: int) -> Any:
        loaded = builder.load(builder.gep(place, [WORD(number)]))
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))  # kernels do not write to tables
        return loaded

    made = ir.Constant(context.get_value_type(_array(word)), None)
    size, shape = np.dtype(DTYPES[word[0]]).itemsize, [read(HEAD + d) for d in range(int(word[1]))]
    data = builder.inttoptr(read(4), made.type.elements[4])
    for entry, value in ((2, read(2)), (3, WORD(size)), (4, data)):
        made = builder.insert_value(made, value, entry)
    stride = WORD(size)
    for d in range(len(shape) - 1, -1, -1):
        made = builder.insert_value(made, shape[d], [5, d])
        made = builder.insert_value(made, stride, [6, d])
        stride = builder.mul(stride, shape[d])
    return made
