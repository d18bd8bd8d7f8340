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

GROUP, STATUSES = "iterations", "statuses"
NOTE = 160  # bytes of a note; what it says of a correction is one short sentence
ROOM = 256  # rows by which room grows, at least
WORD = 8  # bytes by which rows are summed
NUMBERS = IterationRow._fields[:-2]


class IterationTable:
    """The group `contactlab/iterations`: a row of numbers, a note and contact states each, visible after `show`."""

    def __init__(self, growing: GrowingFile, own: h5py.Group) -> None:
        self.growing = growing
        group = own.require_group(GROUP)
        self.numbers = Column(group, "rows", "f8", 1, (len(NUMBERS),), ROOM)
        write_columns(own, f"{GROUP}/rows", NUMBERS)
        self.notes = Column(group, "note", f"S{NOTE}", 1, (), ROOM)
        self.sums = Column(group, "checksum", "u8", 1, (), ROOM)
        self.statuses: Column | None = None
        self.group = group
        if STATUSES in group:
            self._have_statuses(0)
        self.shown = Number(group, "count")
        self.count = self.shown.value

    def add(self, rows: Sequence[IterationRow]) -> None:
        """Append the rows of new Newton iterations."""
        if not rows:
            return
        if self.statuses is None and any(row.statuses for row in rows):
            self._have_statuses(max(len(row.statuses) for row in rows))
        if self.count + len(rows) > self.numbers.room:
            self.growing.grow(self._columns(), max(ROOM, self.count // 8, len(rows)))
        numbers = np.array([row[: len(NUMBERS)] for row in rows], np.float64)
        notes = np.array([row.note.encode()[:NOTE] for row in rows], f"S{NOTE}")
        self.numbers.write(self.count, numbers, len(rows))
        self.notes.write(self.count, notes, len(rows))
        tables = [numbers, notes]
        if self.statuses is not None:
            tables.append(np.array([row.statuses.encode() for row in rows], self.statuses.dtype))
            self.statuses.write(self.count, tables[-1], len(rows))
        self.sums.write(self.count, of_rows(*tables), len(rows))
        self.count += len(rows)

    def _columns(self) -> list[Column]:
        return [self.numbers, self.notes, self.sums, *([self.statuses] if self.statuses is not None else [])]

    def _have_statuses(self, size: int) -> None:
        """Add a column of contact states as long as the others; empty rows do not change their checksums."""
        kind = f"S{max(WORD, -(-size // WORD) * WORD)}"
        self.statuses = Column(self.group, STATUSES, kind, 1, (), ROOM)
        if self.statuses.room < self.numbers.room:
            self.statuses.resize(self.numbers.room)
            self.statuses.write(0, np.zeros(self.numbers.room, self.statuses.dtype), self.numbers.room)

    def show(self) -> None:
        """Make all rows so far visible to readers of the file."""
        self.shown.write(self.count)

    def cut(self, count: int) -> None:
        """Cut the table to exactly `count` rows, without spare room."""
        for column in self._columns():
            column.resize(count)
        self.count = count
        self.show()


def read_iterations(own: h5py.Group, last_step: float, salvage: bool = False) -> list[IterationRow]:
    """Iterations of the steps up to `last_step` from the group `contactlab`; none in explicit runs.

    Raises Damage if a row is not as it was written; with `salvage` such rows are left out.
    """
    if GROUP not in own:
        return []
    group, kinds = own[GROUP], get_type_hints(IterationRow)
    count = int(group.attrs["count"])
    numbers, notes, sums = group["rows"][:count], group["note"][:count], group["checksum"][:count]
    statuses = group[STATUSES][:count] if STATUSES in group else np.zeros(count, f"S{WORD}")
    good = of_rows(numbers, notes, statuses) == sums if count else np.ones(0, np.bool_)
    if not good.all() and not salvage:
        raise Damage(f"{np.count_nonzero(~good)} of {count} rows of iterations are damaged")
    numbers, texts, count = numbers[good], (notes[good], statuses[good]), int(np.count_nonzero(good))
    table = numbers[numbers[:, NUMBERS.index("step")] <= last_step] if count else np.zeros((0, len(NUMBERS)))
    # the record is in the order of the steps: what is left is its beginning
    return [
        IterationRow(*(kinds[name](value) for name, value in zip(NUMBERS, row, strict=True)), *map(bytes.decode, words))
        for row, *words in zip(table.tolist(), *(text[: len(table)].tolist() for text in texts), strict=True)
    ]
