"""Sequences whose items are in a file, each read on access."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar, overload

T = TypeVar("T")


class StoredSequence(Sequence[T], Generic[T]):
    """Indexing and slicing like lists; subclasses give `read` of one item, and `__len__`."""

    @abstractmethod
    def read(self, number: int) -> T:
        """Return item `number`, which is not negative. Raises RequestError if it is damaged."""

    @overload
    def __getitem__(self, number: int) -> T: ...
    @overload
    def __getitem__(self, number: slice) -> list[T]: ...
    def __getitem__(self, number: int | slice) -> T | list[T]:
        """Return an item, negative numbers from the end, or several. Raises IndexError, and errors of `read`."""
        if isinstance(number, slice):
            return [self.read(k) for k in range(*number.indices(len(self)))]
        if not -len(self) <= number < len(self):
            raise IndexError(f"item {number} of {len(self)}")
        return self.read(number % len(self))
