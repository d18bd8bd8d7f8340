"""The arrays of a `BoundArrays` inside a kernel. Imports numba when it is imported."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import from_dtype, types
from numba.extending import intrinsic

from contactlab.api.compiled.bound_arrays import ADDRESS_BITS, DTYPES, members

__all__ = ["unpack"]

STALE = "bound arrays: their BoundArrays object is gone; keep it as long as its address is used"


@intrinsic(prefer_literal=True)
def unpack(typingctx: Any, address: Any, layout: Any) -> Any:
    """The arrays bound at `address`, as a tuple; as a named tuple where `layout`, a constant, is a table.

    `layout` is the one that the arrays were bound with. Raises ValueError where their `BoundArrays` object is gone.
    """
    found = _type_of(layout)
    if found is None:
        return None

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word = args[0].type
        where = builder.and_(args[0], word((1 << ADDRESS_BITS) - 1))
        alive = builder.load(builder.inttoptr(where, word.as_pointer()))
        with builder.if_then(builder.icmp_unsigned("!=", alive, args[0]), likely=False):
            context.call_conv.return_user_exc(builder, ValueError, (STALE,))
        arrays = builder.add(where, word(8))
        return builder.load(builder.inttoptr(arrays, context.get_value_type(found).as_pointer()))

    return found(types.int64, layout), codegen


def _type_of(layout: Any) -> Any:
    if isinstance(layout, types.StringLiteral):
        return _tuple([_array(word) for word in layout.literal_value.split()])
    return _table(layout.instance_class) if isinstance(layout, types.NamedTupleClass) else None


def _table(table: type) -> Any:
    held = members(table).values()
    return _tuple([_array(one) if isinstance(one, str) else _table(one) for one in held], table)


def _tuple(held: list[Any], table: type | None = None) -> Any:
    return types.BaseTuple.from_types(tuple(held), table)


def _array(word: str) -> Any:
    return types.Array(from_dtype(np.dtype(DTYPES[word[0]])), int(word[1]), "C")
