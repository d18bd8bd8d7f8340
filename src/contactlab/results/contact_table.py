"""The contact record in `results.vtkhdf`: a table per contact, a row per step that is kept."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from contactlab.api.contact_steps import contact_record
from contactlab.api.frame import ContactLayout, Layout
from contactlab.results.checksums import GROUP, Damage, of_rows
from contactlab.results.damage import BROKEN, damage_told
from contactlab.results.growing import Column, GrowingFile, Number
from contactlab.results.stored_file import opened
from contactlab.results.stored_sequence import StoredSequence

ROOM = 1 << 18  # bytes by which the room of a table grows, at least
CHUNK = 1 << 15  # bytes of a chunk
AT_ONCE = 1 << 24  # bytes that are read at once


def _name(contact: ContactLayout) -> str:
    return f"contacts/{contact.name}/steps"


class ContactTable:
    """The tables of all contacts of an open file. Rows come into sight with `show`."""

    def __init__(self, growing: GrowingFile, own: h5py.Group, layout: Layout) -> None:
        self.growing = growing
        self.tables: dict[str, Column] = {}
        self.sums: dict[str, Column] = {}
        for contact in layout.contacts:
            kind = contact_record(contact)
            together = max(1, CHUNK // kind.itemsize)
            self.tables[contact.name] = Column(own, _name(contact), kind, 1, (), together)
            self.sums[contact.name] = Column(own.require_group(GROUP), f"{contact.name} steps", "u8", 1, (), CHUNK // 8)
        self.number = Number(own[_name(layout.contacts[0])], "count")
        self.count = self.number.value

    @property
    def columns(self) -> list[Column]:
        """All datasets of the record."""
        return [*self.tables.values(), *self.sums.values()]

    def add(self, block: Mapping[str, np.ndarray]) -> None:
        """Append rows of every contact."""
        size = len(next(iter(block.values())))
        room = min(column.room for column in self.columns)
        if self.count + size > room:
            row = sum(column.row_bytes for column in self.columns)
            self.growing.grow(self.columns, max(size, -(-ROOM // row), self.count // 4))
        for name, rows in block.items():
            self.tables[name].write(self.count, rows, size)
            self.sums[name].write(self.count, sums_of(rows), size)
        self.count += size

    def show(self) -> None:
        """Let readers see all rows so far."""
        self.number.write(self.count)

    def cut(self, count: int) -> None:
        """Have exactly so many rows, and no room for more."""
        for column in self.columns:
            column.resize(count)
        self.count = count
        self.show()


def sums_of(rows: np.ndarray) -> np.ndarray:
    """A checksum of 64 bits for each row."""
    size = rows.dtype.itemsize
    padded = np.zeros((len(rows), -(-size // 8) * 8), np.uint8)
    padded[:, :size] = rows.view(np.uint8).reshape(len(rows), size)
    return of_rows(padded)


def recorded_rows(own: Any, layout: Layout) -> int:
    """Rows of the record in a file; 0 where it has none."""
    return int(own[_name(layout.contacts[0])].attrs["count"]) if is_recorded(own, layout) else 0


def is_recorded(own: Any, layout: Layout) -> bool:
    """Whether a file has a record of contact."""
    return bool(layout.contacts) and _name(layout.contacts[0]) in own


def rows_up_to(own: Any, layout: Layout, rows: int, step: float) -> int:
    """How many of the first `rows` rows are of steps up to `step`."""
    if not rows:
        return 0
    numbers = own[_name(layout.contacts[0])].fields("step")[:rows]
    return int(np.searchsorted(numbers, step, side="right"))


class StoredContactSteps(StoredSequence[np.ndarray]):
    """The record of one contact in blocks of rows, read when they are asked for; `salvage`: those that are whole."""

    def __init__(self, folder: Path, contact: ContactLayout, count: int, salvage: bool = False) -> None:
        self.folder, self.contact, self.total, self.salvage = folder, contact, count, salvage
        self.kind = contact_record(contact)
        self.at_once = max(1, AT_ONCE // self.kind.itemsize)

    def __len__(self) -> int:
        return -(-self.total // self.at_once)

    def read(self, number: int) -> np.ndarray:
        """Block `number`. Raises RequestError where it is damaged."""
        begin = number * self.at_once
        end = min(begin + self.at_once, self.total)
        with opened(self.folder) as file:
            if self.salvage:
                try:
                    rows, good = whole_rows(file["contactlab"], self.contact, begin, end)
                except BROKEN:
                    return np.zeros(0, self.kind)
                return np.asarray(rows[good])
            with damage_told(self.folder):
                rows, good = whole_rows(file["contactlab"], self.contact, begin, end)
                if not good.all():
                    raise Damage(f"{np.count_nonzero(~good)} of {self.total} recorded steps of contact are damaged")
                return rows


def whole_rows(own: Any, contact: ContactLayout, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the record, and which of them are as they were written."""
    rows = np.asarray(own[_name(contact)][begin:end])
    return rows, np.asarray(sums_of(rows) == own[f"{GROUP}/{contact.name} steps"][begin:end])


def check_record(own: Any, layout: Layout, count: int) -> None:
    """Raise Damage where anything of the first `count` rows is not as it was written."""
    for contact in layout.contacts if count else ():
        at_once = max(1, AT_ONCE // contact_record(contact).itemsize)
        for begin in range(0, count, at_once):
            if not whole_rows(own, contact, begin, min(begin + at_once, count))[1].all():
                raise Damage(f"the recorded steps of {contact.name} are damaged")
