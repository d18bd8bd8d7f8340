"""Arrays that are bound once and then passed to kernels as their address.

To pass twenty arrays costs a call of compiled code one microsecond, in tuples three: more than a kernel takes for a
few dozen nodes. A `BoundArrays` object keeps its arrays alive, so its address is valid as long as the object lives;
inside a kernel, `contactlab.api.compiled.unpack` turns the address back into the arrays.

An address that has outlived its object raises an error in the kernel and never reads freed memory: the memory of a
table is never released, and the address contains a serial number which the table repeats while its object lives.
So a stale address is found even if other arrays have been bound at the same place since.

Bound data are described by a layout such as "d2 i1", or by a table: a named tuple whose annotations are the array
types below, or other tables. Inside a kernel the arrays of a table have the names of its fields. A class of objects
that kernels take, a `KernelArgument`, is a table as well, of its fields with such annotations.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from typing import Annotated, Any, Final, get_type_hints
from weakref import ref

import numpy as np
from numpy.typing import NDArray

from contactlab.api.compiled.late import late

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
    "KernelArgument",
    "Shorts2",
    "Singles2",
    "layout_of",
    "members",
    "table_of",
]

ADDRESS_BITS: Final = 48
"""Bits of an address for the position of a table; the others hold its serial number."""

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
    """Return the content of each field of a table: the layout of an array, such as "d2", or another table."""
    hints = get_type_hints(table, include_extras=True)
    held = {name: getattr(hint, "__metadata__", (hint,))[0] for name, hint in hints.items()}
    return {name: one for name, one in held.items() if isinstance(one, str) or issubclass(one, (tuple, KernelArgument))}


@cache
def layout_of(table: type) -> str:
    """Return the layout of all arrays of a table in order, with the tables within it."""
    return " ".join(held if isinstance(held, str) else layout_of(held) for held in members(table).values())


def table_of(table: type, arrays: Iterator[Any]) -> Any:
    """Return the named tuple of arrays as a kernel unpacks it, for kernels that run as plain Python."""
    held = members(table).values()
    return _tuple_of(table)(*(next(arrays) if isinstance(one, str) else table_of(one, arrays) for one in held))


@cache
def _tuple_of(table: type) -> Any:
    return namedtuple(table.__name__, members(table))


class BoundArrays:
    """C-contiguous arrays that stay in place while this object lives, for kernels that `unpack` its `address`.

    `layout` has one word for each array: a letter for its type (d float64, f float32, i int32, l int64, s uint16,
    c uint8, b bool) and its number of dimensions, as in "d2 i1"; or it is a table (see the module). `table` is the
    memory at the address: first the address itself, as long as this object lives, then the arrays in the form in which
    compiled code holds them. Raises TypeError for an array of another type or shape, or not contiguous.
    """

    def __init__(self, layout: str | type, *arrays: Any) -> None:
        words: list[int] = []
        self.layout = layout
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
    """Return memory for a table, never released, and a serial number that no earlier table at this place had."""
    free = _FREE.get(words)
    table, serial = free.pop() if free else (np.zeros(words, np.int64), 0)
    return table, serial + 1


def _flat(arrays: tuple[Any, ...]) -> Iterator[Any]:
    for array in arrays:
        if isinstance(array, tuple):
            yield from _flat(array)
        elif isinstance(array, KernelArgument):
            kind: type = type(array)
            yield from _flat(tuple(getattr(array, name) for name in members(kind)))
        else:
            yield array


class KernelArgument:
    """Base of objects that a kernel takes as one argument: inside it their arrays have the names of the fields.

    A field is an array there if it is annotated as an array, and further arrays if it is such an object. An
    object passed to a kernel keeps its arrays: they are refilled, never replaced.
    """

    @cached_property
    def packed(self) -> BoundArrays:
        """All arrays."""
        return BoundArrays(type(self), self)

    @cached_property
    def _numba_type_(self) -> Any:
        """Return its numba type; arrays that do not fit are found here."""
        return late("contactlab.api.compiled.unpack").Table(self.packed.layout)


class BoundCache:
    """Bound arrays of long-lived objects: made on demand, dropped together with their object.

    They are needed in every step, so the key is the `id` of the object: a weak key costs more than a kernel's call.
    """

    def __init__(self) -> None:
        self._kept: dict[int, tuple[tuple[Any, ...], BoundArrays, ref[Any]]] = {}

    def __contains__(self, owner: Any) -> bool:
        return id(owner) in self._kept

    def of(self, owner: Any, bind: Callable[..., BoundArrays], *sources: Any) -> BoundArrays:
        """Return the result of bind(owner, *sources), renewed as soon as a source is another object."""
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
