"""The contact record in `results.vtkhdf`: a table per contact, a row per step that is kept."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from contactlab.api.contact_steps import contact_record
from contactlab.api.frame import ContactLayout, Layout
from contactlab.api.thinning import Thinning
from contactlab.results.checksums import GROUP, of_rows
from contactlab.results.growing import Column, GrowingFile
from contactlab.results.stored_rows import Pieces, StoredRows, up_to
from contactlab.results.thinned_table import ThinnedTable, pieces_of, thinning_of

CHANGES = "contact_changes"
"""Column: whether a state changed in a row of the record; it only decides which rows are kept."""
MEGABYTE = 1e6
LEAST = 8  # rows
ROOM = 1 << 18  # bytes by which the room of a table grows, at least
CHUNK = ROOM  # bytes of a chunk: HDF5 keeps some 400 B of each in memory
BESIDE = 1 << 15  # the same of checksums and changes, which are shorter


def _name(contact: ContactLayout) -> str:
    return f"contacts/{contact.name}/steps"


class ContactTable:
    """The tables of all contacts of an open file. Rows come into sight with `show`."""

    def __init__(self, growing: GrowingFile, own: h5py.Group, layout: Layout) -> None:
        self.tables: dict[str, Column] = {}
        sums: list[Column] = []
        for contact in layout.contacts:
            kind = contact_record(contact)
            together = max(1, CHUNK // kind.itemsize)
            self.tables[contact.name] = Column(own, _name(contact), kind, 1, (), together)
            sums.append(Column(own.require_group(GROUP), f"{contact.name} steps", "u8", 1, (), BESIDE // 8))
        first = own[_name(layout.contacts[0])]
        self.changed = Column(own, CHANGES, "u1", 1, (), BESIDE)
        columns = [*self.tables.values(), *sums, self.changed]
        row = sum(column.row_bytes for column in columns)
        most = max(LEAST, int(layout.budget * MEGABYTE / row))
        self.kept = ThinnedTable(growing, first, columns, self._look, most, -(-ROOM // row))
        self.states = self._last_states()

    def _last_states(self) -> list[np.ndarray]:
        count = self.kept.count
        return [column.rows(max(0, count - 1), count)["state"] for column in self.tables.values()]

    def _look(self, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
        table = next(iter(self.tables.values()))
        return table.rows(begin, end)["step"], self.changed.rows(begin, end) > 0

    def add(self, block: Mapping[str, np.ndarray]) -> None:
        """Append rows of every contact."""
        rows = [block[name] for name in self.tables]
        size = len(rows[0])
        changed = np.zeros(size, np.uint8)
        for number, table in enumerate(rows):
            before = self.states[number] if len(self.states[number]) else np.zeros_like(table["state"][:1])
            states = np.concatenate([before, table["state"]])
            changed |= (states[1:] != states[:-1]).any(axis=1)
            self.states[number] = states[-1:]
        self.kept.add([*rows, *(sums_of(table) for table in rows), changed], rows[0]["step"])

    def show(self) -> None:
        """Let readers see all rows so far."""
        self.kept.show()

    def cut(self, last_step: int) -> None:
        """Have only rows of steps up to `last_step`, and no room for more."""
        self.kept.cut(last_step)
        self.states = self._last_states()


def sums_of(rows: np.ndarray) -> np.ndarray:
    """A checksum of 64 bits for each row."""
    size = rows.dtype.itemsize
    padded = np.zeros((len(rows), -(-size // 8) * 8), np.uint8)
    padded[:, :size] = rows.view(np.uint8).reshape(len(rows), size)
    return of_rows(padded)


def is_recorded(own: Any, layout: Layout) -> bool:
    """Return whether a file has a record of contact."""
    return bool(layout.contacts) and _name(layout.contacts[0]) in own


def recorded(own: Any, layout: Layout) -> list[tuple[int, int]]:
    """Ranges of the rows of the record in a file."""
    return pieces_of(own[_name(layout.contacts[0])]) if is_recorded(own, layout) else []


def recorded_up_to(own: Any, layout: Layout, rows: Pieces, step: float) -> list[tuple[int, int]]:
    """The same up to a step."""
    return up_to(rows, lambda row: int(own[_name(layout.contacts[0])].fields("step")[row]), step)


def stored_record(
    own: Any, folder: Path, layout: Layout, contact: ContactLayout, rows: Pieces, salvage: bool = False
) -> StoredRows:
    """The record of one contact in blocks of rows."""
    thinning = thinning_of(own[_name(layout.contacts[0])]) if rows else Thinning()
    sums = f"{GROUP}/{contact.name} steps"
    return StoredRows(folder, _name(contact), sums, sums_of, contact_record(contact), rows, thinning, salvage)
