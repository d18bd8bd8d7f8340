"""Checksums of everything that a run stores, so that damage is reported and not read as numbers.

Rows of growing tables have one each, data written once carries its own as an attribute. HDF5 checks the headers of the
file. Checksums of frames are in `frame_sums.py`, those of restart data in `checkpoint_slots.py`.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

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
        dataset.attrs[SEAL] = seal_of(dataset)


def broken_seals(group: h5py.Group) -> list[str]:
    """Names of sealed datasets below `group` that are not as they were written."""
    return [dataset.name for dataset in _fixed(group) if SEAL in dataset.attrs and not is_sealed(dataset)]


def is_sealed(dataset: h5py.Dataset) -> bool:
    """Return whether a dataset that was written once is undamaged."""
    return SEAL in dataset.attrs and int(dataset.attrs[SEAL]) == int(seal_of(dataset))


def sealed(group: h5py.Group, name: str) -> Any:
    """Read a sealed dataset. Raises Damage if its checksum does not fit."""
    dataset = group[name]
    if not is_sealed(dataset):
        raise Damage(f"{name} is damaged")
    return dataset[()]


def seal_of(dataset: h5py.Dataset) -> np.uint32:
    """The checksum of all that a dataset holds."""
    content = dataset[()]
    return np.uint32(zlib.crc32(content) if isinstance(content, bytes) else of_array(content))


def _fixed(group: h5py.Group) -> Iterator[h5py.Dataset]:
    found: list[h5py.Dataset] = []

    def look(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.maxshape == item.shape:
            found.append(item)

    group.visititems(look)
    yield from found
