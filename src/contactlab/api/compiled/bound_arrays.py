"""Arrays bound once and passed to a kernel by one number.

Passing twenty arrays costs a compiled call a microsecond, in tuples three, which is more than a kernel on a few dozen
nodes works. A `BoundArrays` holds references to its arrays, so that its address stays good as long as it lives;
`contactlab.api.compiled.unpack` turns the address into the arrays inside a kernel.
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["DTYPES", "BoundArrays"]

DTYPES = {"d": np.float64, "i": np.int32, "l": np.int64, "b": np.bool_}


class BoundArrays:
    """C-contiguous arrays that never move while this object lives, for kernels that `unpack` its `address`.

    `layout` has a word for each array: a letter for what is in it (d float64, i int32, l int64, b bool) and the number
    of its dimensions, "d2 i1" say. `table` is what the address leads to: the arrays as compiled code holds them.
    """

    def __init__(self, layout: str, *arrays: Any) -> None:
        words: list[int] = []
        for word, array in zip(layout.split(), arrays, strict=True):
            if array.dtype != DTYPES[word[0]] or array.ndim != int(word[1]) or not array.flags.c_contiguous:
                raise TypeError(f"bound array: got {array.dtype} of {array.ndim} dimensions, needed: contiguous {word}")
            # owner and parent: none, `arrays` keeps them; then size, bytes per entry, address, shape and strides
            words += [0, 0, array.size, array.itemsize, array.ctypes.data, *array.shape, *array.strides]
        self.arrays = arrays
        self.table = np.array(words, np.int64)
        self.address = int(self.table.ctypes.data)
