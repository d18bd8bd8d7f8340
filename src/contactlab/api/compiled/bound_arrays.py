"""Arrays that are bound once and passed to a kernel by one number.

Passing twenty arrays costs a compiled call a microsecond, in tuples three, which is more than a kernel on a few dozen
nodes works. A `BoundArrays` holds references to its arrays, so that its address stays good as long as it lives;
`contactlab.api.compiled.unpack` turns the address into the arrays inside a kernel. The memory of tables is never given
back, and an address carries a number of its own that its table repeats while it lives: so an address that has outlived
its object is an error in the kernel, and no read of freed memory, also where other arrays are bound there by then.

What is bound is told by a layout, "d2 i1" say, or by a table: a named tuple whose annotations are the array types
below, or other tables. Inside a kernel a table's arrays have the names of its fields.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Annotated, Any, Final, get_type_hints
from weakref import ref

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ADDRESS_BITS",
    "DTYPES",
    "BoundArrays",
    "BoundCache",
    "Bytes2",
    "Flags1",
    "Floats1",
    "Floats2",
    "Floats3",
    "Floats5",
    "Ints1",
    "Ints2",
    "Shorts2",
    "Singles2",
    "layout_of",
    "members",
]

ADDRESS_BITS: Final = 48
"""Bits of an address that say where a table is; the others hold its serial number."""

LAST_SERIAL: Final = 2**15 - 1  # so that addresses are positive
_FREE: dict[int, list[tuple[NDArray[np.int64], int]]] = {}
_SPENT: list[NDArray[np.int64]] = []

DTYPES = {
    "d": np.float64, "f": np.float32, "i": np.int32, "l": np.int64, "s": np.uint16, "c": np.uint8, "b": np.bool_,
}  # fmt: skip

Floats1 = Annotated[NDArray[np.float64], "d1"]
Floats2 = Annotated[NDArray[np.float64], "d2"]
Floats3 = Annotated[NDArray[np.float64], "d3"]
Floats5 = Annotated[NDArray[np.float64], "d5"]
Ints1 = Annotated[NDArray[np.int32], "i1"]
Ints2 = Annotated[NDArray[np.int32], "i2"]
Flags1 = Annotated[NDArray[np.bool_], "b1"]
Singles2 = Annotated[NDArray[np.float32], "f2"]
Shorts2 = Annotated[NDArray[np.uint16], "s2"]
Bytes2 = Annotated[NDArray[np.uint8], "c2"]


@cache
def members(table: type) -> dict[str, str | type]:
    """What the fields of a table hold: the word of an array, "d2" say, or another table."""
    hints = get_type_hints(table, include_extras=True)
    return {name: getattr(hint, "__metadata__", (hint,))[0] for name, hint in hints.items()}


@cache
def layout_of(table: type) -> str:
    """The layout of all arrays of a table, those of the tables within it included, one after another."""
    return " ".join(held if isinstance(held, str) else layout_of(held) for held in members(table).values())


class BoundArrays:
    """C-contiguous arrays that never move while this object lives, for kernels that `unpack` its `address`.

    `layout` has a word for each array: a letter for what is in it (d float64, f float32, i int32, l int64, s uint16,
    c uint8, b bool) and the number of its dimensions, "d2 i1" say; or it is a table (see the module). `table` is what
    the address leads to: the address itself while this object lives, then the arrays as compiled code holds them.
    """

    def __init__(self, layout: str | type, *arrays: Any) -> None:
        words: list[int] = []
        layout = layout if isinstance(layout, str) else layout_of(layout)
        self.arrays = tuple(_flat(arrays))
        for word, array in zip(layout.split(), self.arrays, strict=True):
            if array.dtype != DTYPES[word[0]] or array.ndim != int(word[1]) or not array.flags.c_contiguous:
                raise TypeError(f"bound array: got {array.dtype} of {array.ndim} dimensions, needed: contiguous {word}")
            # owner and parent: none, `arrays` keeps them; then size, bytes per entry, address, shape and strides
            words += [0, 0, array.size, array.itemsize, array.ctypes.data, *array.shape, *array.strides]
        self.table, self._serial = _room(1 + len(words))
        self.address = int(self.table.ctypes.data) | self._serial << ADDRESS_BITS
        self.table[0], self.table[1:] = self.address, words

    def __del__(self) -> None:
        if hasattr(self, "address"):
            self.table[0] = 0
            if self._serial < LAST_SERIAL:
                _FREE.setdefault(len(self.table), []).append((self.table, self._serial))
            else:
                _SPENT.append(self.table)


def _room(words: int) -> tuple[NDArray[np.int64], int]:
    """Memory for a table, which is never given back, and a serial number that no table there had before."""
    free = _FREE.get(words)
    table, serial = free.pop() if free else (np.zeros(words, np.int64), 0)
    return table, serial + 1


def _flat(arrays: tuple[Any, ...]) -> Iterator[Any]:
    for array in arrays:
        if isinstance(array, tuple):
            yield from _flat(array)
        else:
            yield array


class BoundCache:
    """Bound arrays of objects that live for long, made when they are first asked for and forgotten with the object.

    Asked for in every step: by the number of the object, since a weak key costs more than a kernel's call.
    """

    def __init__(self) -> None:
        self._kept: dict[int, tuple[tuple[Any, ...], BoundArrays, ref[Any]]] = {}

    def of(self, owner: Any, bind: Callable[..., BoundArrays], *sources: Any) -> BoundArrays:
        """What bind(owner, *sources) gave; asked again where one of the sources is another object than it was then."""
        number = id(owner)
        found = self._kept.get(number)
        if found is not None:
            for one, other in zip(found[0], sources, strict=True):
                if one is not other:
                    break
            else:
                return found[1]
        bound = bind(owner, *sources)
        self._kept[number] = sources, bound, ref(owner, lambda _: self._kept.pop(number, None))
        return bound
