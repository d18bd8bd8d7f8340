"""Named tuples that kernels read from columns of arrays and write to them. Imports numba when it is imported."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_item_pointer
from numba.core.imputils import impl_ret_untracked
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from contactlab.api.compiled.dual import Dual

__all__ = ["column", "put_column"]

_I64 = ir.IntType(64)


def _place(context: Any, builder: Any, array_type: Any, array: Any, row: int, number: Any) -> Any:
    """Return the address of array[row, number], or array[row] of an array of one dimension."""
    indices = [_I64(row), number][: array_type.ndim]
    return get_item_pointer(context, builder, array_type, make_array(array_type)(context, builder, array), indices)


@intrinsic
def column(typingctx: Any, array: Any, number: Any, kind: Any) -> Any:
    """Return column `number` of an array (rows, P), or all of an array (rows,), as a named tuple of class `kind`."""
    fields = kind.instance_class._fields
    found = types.BaseTuple.from_types((types.float64,) * len(fields), kind.instance_class)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = context.cast(builder, args[1], number, types.int64)
        held = [builder.load(_place(context, builder, array, args[0], row, at)) for row in range(len(fields))]
        return impl_ret_untracked(context, builder, found, context.make_tuple(builder, found, held))

    return found(array, number, kind), codegen


@intrinsic
def put_column(typingctx: Any, array: Any, number: Any, numbers: Any) -> Any:
    """Write a tuple of numbers into column `number` of an array (rows, P); derivatives of dual numbers are left out."""
    if not isinstance(numbers, types.BaseTuple):
        return None

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = context.cast(builder, args[1], number, types.int64)
        for row, kind in enumerate(numbers.types):
            held = builder.extract_value(args[2], row)
            held = (
                builder.extract_value(held, 0)
                if isinstance(kind, Dual)
                else context.cast(builder, held, kind, types.float64)
            )
            builder.store(held, _place(context, builder, array, args[0], row, at))
        return context.get_dummy_value()

    return types.none(array, number, numbers), codegen
