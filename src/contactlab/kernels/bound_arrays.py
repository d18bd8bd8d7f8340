"""Arrays bound once and passed to a kernel by address.

Passing ten arrays costs a compiled call more than half a microsecond, most of what one sample of a
step may cost. A `BoundArrays` holds references to its arrays, so that addresses stay good.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

__all__ = ["BoundArrays", "pointer"]


class BoundArrays:
    """C-contiguous arrays that never move while this object lives; `table` (2, k) int64 holds address and size."""

    def __init__(self, *arrays: np.ndarray) -> None:
        assert all(array.flags.c_contiguous for array in arrays)
        self.arrays = arrays
        self.table = np.array([[a.ctypes.data for a in arrays], [a.size for a in arrays]], np.int64)


@intrinsic
def pointer(typingctx: Any, address: Any) -> Any:
    """The address of an array as `numba.carray` takes it."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), codegen
