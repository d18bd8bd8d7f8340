"""Checksums of everything that a run stores, so that damage is told and not read as numbers.

A frame has one per array, in a row that has one itself; rows of growing tables have one each; what is written once
carries its own as an attribute. The headers of the file are checked by HDF5. What a restart needs is in
`checkpoint_slots.py`.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from typing import Any

import h5py
import numpy as np

from contactlab.results.growing import Column

GROUP = "checksums"
SEAL = "crc32"


class Damage(ValueError):
    """Something stored is not as it was written; the text names it."""


def of_rows(*tables: np.ndarray) -> np.ndarray:
    """A checksum (n,) of 64 bits for each row of tables (n, ...) side by side; any change of one word changes it."""
    parts = [np.ascontiguousarray(table).view(np.uint8).reshape(len(table), -1) for table in tables]
    words = np.ascontiguousarray(np.concatenate(parts, axis=1)).view(np.uint64)
    # odd factors and shifts can be undone: no two values of a word give the same
    factors = np.uint64(0x9E3779B97F4A7C15) * (2 * np.arange(words.shape[1], dtype=np.uint64) + 1)
    mixed = words * factors
    mixed ^= mixed >> np.uint64(29)
    return np.asarray((mixed * factors).sum(axis=1, dtype=np.uint64) + np.uint64(1))


def of_array(array: np.ndarray) -> int:
    """A checksum of 32 bits of an array."""
    data: Any = np.ascontiguousarray(array)
    return zlib.crc32(data)


def of_text(*values: Any) -> int:
    """A checksum of 32 bits of a few values as text."""
    return zlib.crc32(repr(values).encode())


def seal(group: h5py.Group) -> None:
    """Give every dataset below `group` that never grows its checksum."""
    for dataset in _fixed(group):
        dataset.attrs[SEAL] = np.uint32(_of_dataset(dataset))


def broken_seals(group: h5py.Group) -> list[str]:
    """Names of sealed datasets below `group` that are not as they were written."""
    return [dataset.name for dataset in _fixed(group) if SEAL in dataset.attrs and not is_sealed(dataset)]


def is_sealed(dataset: h5py.Dataset) -> bool:
    """Whether what was written once is as it was written."""
    return SEAL in dataset.attrs and int(dataset.attrs[SEAL]) == _of_dataset(dataset)


def sealed(group: h5py.Group, name: str) -> Any:
    """Read a sealed dataset. Raises Damage where its checksum does not fit."""
    dataset = group[name]
    if not is_sealed(dataset):
        raise Damage(f"{name} is damaged")
    return dataset[()]


def _of_dataset(dataset: h5py.Dataset) -> int:
    content = dataset[()]
    return zlib.crc32(content) if isinstance(content, bytes) else of_array(content)


def _fixed(group: h5py.Group) -> Iterator[h5py.Dataset]:
    found: list[h5py.Dataset] = []

    def look(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.maxshape == item.shape:
            found.append(item)

    group.visititems(look)
    yield from found


class FrameSums:
    """Checksums of the frames: a row for each, a column per array, and one for the row."""

    def __init__(self, own: h5py.Group, names: Sequence[str]) -> None:
        self.column = Column(own.require_group(GROUP), "frames", "u4", 1, (len(names) + 1,))
        self.column.dataset.attrs["names"] = list(names)

    def write(self, row: int, sums: Sequence[int]) -> None:
        """Write the checksums of the frame `row`."""
        values = np.array(sums, np.uint32)
        self.column.write(row, np.append(values, np.uint32(of_array(values))))


class StoredSums:
    """The same, read: does what was read belong to its frame?"""

    def __init__(self, own: h5py.Group) -> None:
        self.table = own[f"{GROUP}/frames"][:]
        self.place = {str(name): i for i, name in enumerate(own[f"{GROUP}/frames"].attrs["names"])}
        self.whole = [int(row[-1]) == of_array(row[:-1]) for row in self.table]

    def holds(self, number: int, name: str, content: np.ndarray) -> bool:
        """Whether `content` is array `name` of frame `number` as it was written."""
        known = number < len(self.table) and self.whole[number]
        return known and int(self.table[number, self.place[name]]) == of_array(content)

    def check(self, number: int, name: str, content: np.ndarray) -> np.ndarray:
        """`content`. Raises Damage where it is not as it was written."""
        if not self.holds(number, name, content):
            raise Damage(f"{name} of frame {number} is damaged")
        return content
