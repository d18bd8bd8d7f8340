"""Checksums of frames: one per array, in a row that has one itself."""

from __future__ import annotations

from collections.abc import Sequence

import h5py
import numpy as np

from contactlab.results.checksums import GROUP, Damage, of_array
from contactlab.results.growing import Column
from contactlab.results.stored_text import read_columns, write_columns

TABLE = f"{GROUP}/frames"


class FrameSums:
    """Checksums of the frames: a row for each, a column per array, and one for the row."""

    def __init__(self, own: h5py.Group, names: Sequence[str]) -> None:
        self.column = Column(own.require_group(GROUP), "frames", "u4", 1, (len(names) + 1,))
        write_columns(own, TABLE, names)

    def write(self, row: int, sums: Sequence[int]) -> None:
        """Write the checksums of the frame `row`."""
        values = np.array(sums, np.uint32)
        self.column.write(row, np.append(values, np.uint32(of_array(values))))


class StoredSums:
    """The same, read: does what was read belong to its frame?"""

    def __init__(self, own: h5py.Group) -> None:
        self.table = own[TABLE][:]
        self.place = {name: i for i, name in enumerate(read_columns(own, TABLE))}
        self.whole = [int(row[-1]) == of_array(row[:-1]) for row in self.table]

    def holds(self, number: int, name: str, content: np.ndarray) -> bool:
        """Return whether `content` is array `name` of frame `number` as it was written."""
        known = number < len(self.table) and self.whole[number]
        return known and int(self.table[number, self.place[name]]) == of_array(content)

    def check(self, number: int, name: str, content: np.ndarray) -> np.ndarray:
        """Return `content`. Raises Damage if it is not as it was written."""
        if not self.holds(number, name, content):
            raise Damage(f"{name} of frame {number} is damaged")
        return content
