"""Newton iterations in `results.vtkhdf`: present only in implicit runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_type_hints

import h5py
import numpy as np

from contactlab.api.frame import IterationRow
from contactlab.results.checksums import Damage, of_rows
from contactlab.results.growing import Column, GrowingFile, Number
from contactlab.results.stored_text import write_columns

GROUP = "iterations"
NOTE = 160  # bytes of a note; what it says of a correction is one short sentence
ROOM = 256  # rows by which room grows, at least
NUMBERS = IterationRow._fields[:-1]


class IterationTable:
    """The group `contactlab/iterations`: a row of numbers and a note each. Rows come into sight with `show`."""

    def __init__(self, growing: GrowingFile, own: h5py.Group) -> None:
        self.growing = growing
        group = own.require_group(GROUP)
        self.numbers = Column(group, "rows", "f8", 1, (len(NUMBERS),), ROOM)
        write_columns(own, f"{GROUP}/rows", NUMBERS)
        self.notes = Column(group, "note", f"S{NOTE}", 1, (), ROOM)
        self.sums = Column(group, "checksum", "u8", 1, (), ROOM)
        self.shown = Number(group, "count")
        self.count = self.shown.value

    def add(self, rows: Sequence[IterationRow]) -> None:
        """Append the rows of new Newton iterations."""
        if not rows:
            return
        if self.count + len(rows) > self.numbers.room:
            self.growing.grow([self.numbers, self.notes, self.sums], max(ROOM, self.count // 8, len(rows)))
        numbers = np.array([row[:-1] for row in rows], np.float64)
        notes = np.array([row.note.encode()[:NOTE] for row in rows], f"S{NOTE}")
        self.numbers.write(self.count, numbers, len(rows))
        self.notes.write(self.count, notes, len(rows))
        self.sums.write(self.count, of_rows(numbers, notes), len(rows))
        self.count += len(rows)

    def show(self) -> None:
        """Make all rows so far visible to readers of the file."""
        self.shown.write(self.count)

    def cut(self, count: int) -> None:
        """Cut the table to exactly `count` rows, without spare room."""
        for column in (self.numbers, self.notes, self.sums):
            column.resize(count)
        self.count = count
        self.show()


def read_iterations(own: h5py.Group, last_step: float, salvage: bool = False) -> list[IterationRow]:
    """Iterations of the steps up to `last_step` from the group `contactlab`; none in explicit runs.

    Raises Damage where a row is not as it was written; with `salvage` such rows are left out.
    """
    if GROUP not in own:
        return []
    group, kinds = own[GROUP], get_type_hints(IterationRow)
    count = int(group.attrs["count"])
    numbers, notes, sums = group["rows"][:count], group["note"][:count], group["checksum"][:count]
    good = of_rows(numbers, notes) == sums if count else np.ones(0, np.bool_)
    if not good.all() and not salvage:
        raise Damage(f"{np.count_nonzero(~good)} of {count} rows of iterations are damaged")
    numbers, notes, count = numbers[good], notes[good], int(np.count_nonzero(good))
    table = numbers[numbers[:, NUMBERS.index("step")] <= last_step] if count else np.zeros((0, len(NUMBERS)))
    # the record is in the order of the steps: what is left is its beginning
    return [
        IterationRow._make([*(kinds[name](value) for name, value in zip(NUMBERS, row, strict=True)), note.decode()])
        for row, note in zip(table.tolist(), notes[: len(table)], strict=True)
    ]
