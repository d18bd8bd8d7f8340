"""Rows of steps in `results.vtkhdf`, read in blocks on access, each row with its checksum."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api.thinning import Thinning
from contactlab.results.checksums import Damage
from contactlab.results.damage import BROKEN, damage_told
from contactlab.results.stored_file import opened
from contactlab.results.stored_sequence import StoredSequence

AT_ONCE = 1 << 24  # bytes of a read

Pieces = Sequence[tuple[int, int]]
"""Ranges of rows, one after the other."""

Sums = Callable[[np.ndarray], np.ndarray]


class StoredRows(StoredSequence[np.ndarray]):
    """Blocks of the rows in `pieces` of a table of the group `contactlab`; with `salvage` those that are whole.

    table, sums  datasets with the rows and with their checksums, which `sums_of` makes
    thinning     what was left out of the steps before
    """

    def __init__(
        self,
        folder: Path,
        table: str,
        sums: str,
        sums_of: Sums,
        kind: np.dtype[Any],
        pieces: Pieces,
        thinning: Thinning,
        salvage: bool = False,
        columns: int = 1,
    ) -> None:
        self.folder, self.table, self.sums, self.sums_of, self.kind = folder, table, sums, sums_of, kind
        self.thinning, self.salvage = thinning, salvage
        self.total = sum(end - begin for begin, end in pieces)
        self.blocks = list(blocks_of(pieces, kind.itemsize * columns))
        self.shape = (columns,) if columns > 1 else ()

    def __len__(self) -> int:
        return len(self.blocks)

    def read(self, number: int) -> np.ndarray:
        """Return block `number`. Raises RequestError if it is damaged."""
        with opened(self.folder) as file:
            own, block = file["contactlab"], self.blocks[number]
            if not self.salvage:
                with damage_told(self.folder):
                    return self._whole(own, block)
            try:
                rows, good = self._checked(own, block)
            except BROKEN:
                return np.zeros((0, *self.shape), self.kind)
            return np.asarray(rows[good])

    def check(self, own: Any) -> None:
        """Raise Damage if any row is not as it was written."""
        for block in self.blocks:
            self._whole(own, block)

    def _whole(self, own: Any, block: tuple[int, int]) -> np.ndarray:
        rows, good = self._checked(own, block)
        if not good.all():
            raise Damage(f"{np.count_nonzero(~good)} of {self.total} rows of {self.table} are damaged")
        return rows

    def _checked(self, own: Any, block: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Rows, and which of them are as they were written."""
        begin, end = block
        rows = np.asarray(own[self.table][begin:end])
        return rows, np.asarray(self.sums_of(rows) == own[self.sums][begin:end])


def blocks_of(pieces: Pieces, row: int) -> Iterable[tuple[int, int]]:
    """Split into ranges of one read each, for rows of `row` bytes."""
    rows = max(1, AT_ONCE // max(1, row))
    for begin, end in pieces:
        for first in range(begin, end, rows):
            yield first, min(first + rows, end)


def up_to(pieces: Pieces, look: Callable[[int], int], last_step: float) -> list[tuple[int, int]]:
    """The same without rows of later steps; `look` gives the step of a row."""
    found = []
    for begin, end in pieces:
        low, high = begin, end
        while low < high:
            middle = (low + high) // 2
            low, high = (middle + 1, high) if look(middle) <= last_step else (low, middle)
        found.append((begin, low))
    return found
