"""Sequences whose items are in a file, each read when it is asked for."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar, overload

T = TypeVar("T")


class StoredSequence(Sequence[T], Generic[T]):
    """What lists do with numbers and slices; `read` has one item, and `__len__` how many there are."""

    @abstractmethod
    def read(self, number: int) -> T:
        """Item `number`, which is not negative. Raises RequestError where it is damaged."""

    @overload
    def __getitem__(self, number: int) -> T: ...
    @overload
    def __getitem__(self, number: slice) -> list[T]: ...
    def __getitem__(self, number: int | slice) -> T | list[T]:
        """One item, negative numbers from the end, or several. Raises IndexError, and what `read` raises."""
        if isinstance(number, slice):
            return [self.read(k) for k in range(*number.indices(len(self)))]
        if not -len(self) <= number < len(self):
            raise IndexError(f"item {number} of {len(self)}")
        return self.read(number % len(self))
