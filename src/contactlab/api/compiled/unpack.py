"""The arrays of a `BoundArrays` inside a kernel. Imports numba when it is imported."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import from_dtype, types
from numba.extending import intrinsic

from contactlab.api.compiled.bound_arrays import DTYPES

__all__ = ["unpack"]


@intrinsic(prefer_literal=True)
def unpack(typingctx: Any, address: Any, layout: Any) -> Any:
    """Tuple of the arrays bound at `address` with the same `layout`, a constant."""
    if not isinstance(layout, types.StringLiteral):
        return None
    words = layout.literal_value.split()
    found: Any = types.BaseTuple.from_types(
        tuple(types.Array(from_dtype(np.dtype(DTYPES[word[0]])), int(word[1]), "C") for word in words)
    )

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(builder.inttoptr(args[0], context.get_value_type(found).as_pointer()))

    return found(types.int64, layout), codegen
