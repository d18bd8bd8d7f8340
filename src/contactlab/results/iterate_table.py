"""States after Newton's iterations in `results.vtkhdf`: displacements and gaps of each that is kept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from contactlab.api.frame import Iterate
from contactlab.results.checksums import Damage, of_rows
from contactlab.results.damage import BROKEN, damage_told
from contactlab.results.growing import Column, GrowingFile, Number
from contactlab.results.stored_file import opened
from contactlab.results.stored_sequence import StoredSequence

GROUP = "iterates"
ROOM = 1 << 18  # bytes by which room grows, at least
TOGETHER = 64  # numbers and checksums of a chunk


class IterateTable:
    """The group `contactlab/iterates`, in sight with `show`."""

    def __init__(self, growing: GrowingFile, own: h5py.Group, nodes: int, gaps: int) -> None:
        self.growing = growing
        group = own.require_group(GROUP)
        self.numbers = Column(group, "number", "i8", 1, (), TOGETHER)
        self.sums = Column(group, "checksum", "u8", 1, (), TOGETHER)
        self.tables = [Column(group, "displacement", "f4", 1, (nodes, 2)), Column(group, "gap", "f4", 1, (gaps,))]
        self.shown = Number(group, "count")
        self.count = self.shown.value

    @classmethod
    def there(cls, growing: GrowingFile, own: h5py.Group) -> IterateTable | None:
        """Open the table of a file; None if it has no table."""
        if GROUP not in own:
            return None
        group = own[GROUP]
        return cls(growing, own, group["displacement"].shape[1], group["gap"].shape[1])

    @property
    def columns(self) -> list[Column]:
        """All datasets of the group."""
        return [self.numbers, self.sums, *self.tables]

    def add(self, some: Sequence[Iterate]) -> None:
        """Append states in the order of their iterations."""
        if self.count + len(some) > min(column.room for column in self.columns):
            row = sum(column.row_bytes for column in self.columns)
            self.growing.grow(self.columns, max(len(some), -(-ROOM // row), self.count // 4))
        for one in some:
            self.numbers.write(self.count, np.array([one.number]))
            for column, values in zip(self.tables, (one.displacement, one.gap), strict=True):
                column.write(self.count, values)
            self.sums.write(self.count, np.array([_sum_of(one)], np.uint64))
            self.count += 1

    def show(self) -> None:
        """Let readers see all rows so far."""
        self.shown.write(self.count)

    def cut(self, iterations: int | None = None) -> None:
        """Have only rows of the first so many iterations, and no room for more."""
        if iterations is not None:
            numbers = self.numbers.dataset[: self.count]
            self.count = int(np.searchsorted(numbers, iterations, side="right"))
        for column in self.columns:
            column.resize(self.count)
        self.show()


class StoredIterates(StoredSequence[Iterate]):
    """States of the first `iterations` iterations, each read on access; with `salvage` only the undamaged ones."""

    what = "iterate"

    def __init__(self, folder: Path, own: Any, iterations: int, salvage: bool = False) -> None:
        self.folder = folder
        self.rows: list[int] = []
        if GROUP not in own:
            return
        group = own[GROUP]
        numbers = group["number"][: int(group.attrs["count"])]
        self.rows = list(range(int(np.searchsorted(numbers, iterations, side="right"))))
        if salvage:
            self.rows = [row for row in self.rows if _whole(group, row) is not None]

    def __len__(self) -> int:
        return len(self.rows)

    def read(self, number: int) -> Iterate:
        """Return state `number`. Raises RequestError if it is damaged."""
        with opened(self.folder) as file, damage_told(self.folder):
            return checked_iterate(file["contactlab"], self.rows[number])

    def __iter__(self) -> Iterator[Iterate]:
        with opened(self.folder) as file:
            for row in self.rows:
                with damage_told(self.folder):
                    one = checked_iterate(file["contactlab"], row)
                yield one


def checked_iterate(own: Any, row: int) -> Iterate:
    """Read a row of the group. Raises Damage if it is not as it was written."""
    if (found := _whole(own[GROUP], row)) is None:
        raise Damage(f"row {row} of {GROUP} is damaged")
    return found


def check_iterates(own: Any, iterations: int) -> None:
    """Raise Damage if anything of the first so many iterations is not as it was written."""
    if GROUP not in own:
        return
    numbers = own[f"{GROUP}/number"][: int(own[GROUP].attrs["count"])]
    for row in range(int(np.searchsorted(numbers, iterations, side="right"))):
        checked_iterate(own, row)


def _whole(group: Any, row: int) -> Iterate | None:
    try:
        one = Iterate(int(group["number"][row]), group["displacement"][row], group["gap"][row])
        return one if _sum_of(one) == group["checksum"][row] else None
    except BROKEN:
        return None


def _sum_of(one: Iterate) -> np.uint64:
    """The checksum of a row, of 64 bits."""
    words = np.concatenate([np.array([one.number], "i8").view("u4"), *(v.ravel().view("u4") for v in one[1:])])
    padded = np.zeros(2 * (-(-len(words) // 2)), np.uint32)
    padded[: len(words)] = words
    sums: np.ndarray = of_rows(padded[None])
    return np.uint64(sums[0])
