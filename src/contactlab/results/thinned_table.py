"""Rows of steps in `results.vtkhdf`, as many as there is room for: when it is full, older rows are thinned in place.

Everything about it follows from the rows alone: a run that was killed and resumed ends with the same rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import h5py
import numpy as np

from contactlab.api.thinning import Thinning, recent_steps, thinned
from contactlab.results.growing import Column, GrowingFile, Number

AT_ONCE = 2**20  # bytes of rows that are moved together
NUMBERS = ("hole_begin", "hole_end", "thinned_at", "said_at", *Thinning._fields)
"""Attributes in addition to `count`, eight in all, as HDF5 has no checksum for more: rows from hole_begin to hole_end
are invalid while others are moved; the steps at which rows were last left out, and at which more of them were."""

Looked = tuple[np.ndarray, np.ndarray]
"""Numbers of steps (n,), and in which of them a contact state changed (n,)."""


class ThinnedTable:
    """Columns with a row for each step that is kept; `shown` of them are in sight.

    look   reads steps and changes of the rows from ... to ...
    most   rows; 0: as many as come
    least  rows by which room grows
    """

    def __init__(
        self,
        growing: GrowingFile,
        owner: h5py.Dataset,
        columns: Sequence[Column],
        look: Callable[[int, int], Looked],
        most: int,
        least: int,
    ) -> None:
        self.growing, self.columns, self.look, self.most, self.least = growing, columns, look, most, least
        self.together = max(1, AT_ONCE // sum(column.row_bytes for column in columns))
        self.shown = Number(owner, "count")
        start = {"stride": 1, "changes": 1}
        self.numbers = {name: Number(owner, name, start.get(name, 0)) for name in NUMBERS}
        self.count = self.shown.value
        self.again = False  # rows up to `thinned_at` are thinned already, those that come up to there are not

    @property
    def thinning(self) -> Thinning:
        """Thinning of the table so far."""
        return Thinning(*(self.numbers[name].value for name in Thinning._fields))

    @property
    def sparser_at(self) -> int:
        """The step at which it was last decided to leave out more, 0 if never."""
        at = self.numbers["said_at"].value
        return 0 if self.again and at == self.numbers["thinned_at"].value else at

    def add(self, tables: Sequence[np.ndarray], steps: np.ndarray) -> None:
        """Append rows of these steps, a table for each column."""
        begin = 0
        while begin < len(steps):
            end = len(steps) if not self.most else min(len(steps), begin + self.most - self.count)
            if self.again:
                end = min(end, int(np.searchsorted(steps, self.numbers["thinned_at"].value, side="right")))
            self._append([table[begin:end] for table in tables])
            begin = end
            if self.again and steps[end - 1] == self.numbers["thinned_at"].value:
                self.again = False
                self._thin(self.thinning)
            elif (
                self.count == self.most and self.again
            ):  # what was left out after the last saved state is known already
                self._move(self.thinning._replace(until=int(steps[end - 1]) - recent_steps(self.most)), 0, 0)
            elif self.count == self.most:
                last = int(steps[end - 1])
                blocks = range(0, self.count, self.together)
                rows = (self.look(begin, min(begin + self.together, self.count)) for begin in blocks)
                self._thin(thinned(rows, last, self.most, self.thinning), last)

    @property
    def last_step(self) -> int:
        """Number of the last step, 0 if there is none."""
        return int(self.look(self.count - 1, self.count)[0][0]) if self.count else 0

    def show(self) -> None:
        """Let readers see all rows so far."""
        self.shown.write(self.count)

    def cut(self, last_step: float) -> None:
        """Have only rows of steps up to `last_step`, and no room for more."""
        begin, end = self.numbers["hole_begin"].value, self.numbers["hole_end"].value
        if end > begin:  # it was killed while it moved rows
            self._move(self.thinning, begin, end)
        low, high = 0, self.count
        while low < high:
            middle = (low + high) // 2
            low, high = (middle + 1, high) if self.look(middle, middle + 1)[0][0] <= last_step else (low, middle)
        self.count = low
        self.again = self.numbers["thinned_at"].value > last_step
        self.show()
        for column in self.columns:
            column.resize(self.count)

    def _append(self, tables: Sequence[np.ndarray]) -> None:
        rows = len(tables[0])
        if self.count + rows > self.columns[0].room:
            more = max(rows, self.least, self.count // 8)
            more = min(more, self.most - self.columns[0].room) if self.most else more
            self.growing.grow(self.columns, more)
        for column, table in zip(self.columns, tables, strict=True):
            column.write(self.count, table, rows)
        self.count += rows

    def _thin(self, thinning: Thinning, now: int = 0) -> None:
        if now:
            self.numbers["thinned_at"].write(now)
            if thinning[1:] != self.thinning[1:]:
                self.numbers["said_at"].write(now)
        for name, value in thinning._asdict().items():
            self.numbers[name].write(value)
        self.show()
        self._move(thinning, 0, 0)

    def _move(self, thinning: Thinning, to: int, begin: int) -> None:
        """Move the rows that stay, from row `begin` on, to row `to` and behind it."""
        while begin < self.count:
            end = min(begin + self.together, self.count)
            keeps = thinning.keeps(*self.look(begin, end))
            stay = int(np.count_nonzero(keeps))
            if stay and (to < begin or stay < end - begin):
                # rows that would be written over themselves go through the journal
                safe = to + stay <= begin
                for column in self.columns:
                    column.write(to, column.rows(begin, end)[keeps], stay, around=safe)
            to, begin = to + stay, end
            self.numbers["hole_begin"].write(to)
            self.numbers["hole_end"].write(begin)
            self.growing.flush()
        self.count = to
        self.show()
        self.numbers["hole_begin"].write(0)
        self.numbers["hole_end"].write(0)
        self.growing.flush()


def pieces_of(owner: Any) -> list[tuple[int, int]]:
    """The ranges of rows in sight of a stored table: one, or two where a process was killed while it moved rows."""
    count = int(owner.attrs["count"])
    begin, end = (int(owner.attrs.get(name, 0)) for name in NUMBERS[:2])
    if not 0 <= begin <= end <= count:
        raise ValueError("the numbers of the rows are damaged")
    return [(0, begin), (end, count)] if end > begin else [(0, count)]


def thinning_of(owner: Any) -> Thinning:
    """Return the thinning of a stored table."""
    return Thinning(*(int(owner.attrs.get(name, value)) for name, value in Thinning()._asdict().items()))
