"""Sequences whose items are in a file, each read on access; and messages for items that they do not have."""

from __future__ import annotations

import operator
from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Generic, SupportsIndex, TypeVar, overload

T = TypeVar("T")


def place_of(number: SupportsIndex, count: int, what: str, none: str = "") -> int:
    """Place of an item among `count`, from 0; negative numbers count from the end.

    what  an item, "frame"; none: why there is none, and what to try

    Raises TypeError for anything but a whole number, and IndexError with the numbers there are.
    """
    try:
        place = operator.index(number)
    except TypeError:
        raise TypeError(f"a {what} is named by a whole number or a slice, not by {number!r}") from None
    if not count:
        raise IndexError(f"no {what} {place}: {none or 'none is stored'}")
    if not -count <= place < count:
        raise IndexError(f"no {what} {place}: there are {count}, 0 to {count - 1}, or -{count} to -1 from the end")
    return place % count


class NoneStored(tuple[T, ...]):
    """An empty tuple whose IndexError says why it is empty."""

    what: str
    hint: str

    @classmethod
    def of(cls, what: str, hint: str) -> NoneStored[T]:
        """No item `what`, "frame"; `hint` says why, and what to try."""
        made = cls()
        made.what, made.hint = what, hint
        return made

    @overload
    def __getitem__(self, number: SupportsIndex) -> T: ...
    @overload
    def __getitem__(self, number: slice) -> tuple[T, ...]: ...
    def __getitem__(self, number: SupportsIndex | slice) -> T | tuple[T, ...]:
        """Return no items for a slice. Raises IndexError, and TypeError for what is no number."""
        return () if isinstance(number, slice) else super().__getitem__(place_of(number, 0, self.what, self.hint))


class StoredSequence(Sequence[T], Generic[T]):
    """Indexing and slicing like lists; subclasses give `read` of one item, `what` it is, and `__len__`."""

    what: ClassVar[str] = "item"

    @abstractmethod
    def read(self, number: int) -> T:
        """Return item `number`, which is not negative. Raises RequestError if it is damaged."""

    @overload
    def __getitem__(self, number: int) -> T: ...
    @overload
    def __getitem__(self, number: slice) -> list[T]: ...
    def __getitem__(self, number: int | slice) -> T | list[T]:
        """Return an item, negative numbers from the end, or several. Raises as `place_of` and `read` do."""
        if isinstance(number, slice):
            return [self.read(k) for k in range(*number.indices(len(self)))]
        return self.read(place_of(number, len(self), self.what))
