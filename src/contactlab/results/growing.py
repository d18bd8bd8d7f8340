"""Datasets that grow in a file which stays readable whatever happens.

Room for many rows is set aside on the disk before any is written, with the chunks and headers that belong to it, in
one change of the file (`journaled.py`): a full disk is then met while the file is whole, and a row changes nothing
but numbers.

h5py's low-level calls are used where something happens at every frame: they cost a fifth.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from contactlab.results.journaled import JournaledFile, written

NOWHERE = np.zeros(0, np.int64)
INDICES = (
    2**16
)  # bytes of indices of chunks that HDF5 keeps, which take eight times as much; 2 MiB by itself, row by row
HEADERS = ("v108", "v108")  # the oldest format whose headers have checksums; later ones mark a file as open


class GrowingFile:
    """An HDF5 file open for writing, which others can read meanwhile.

    A new file has another name until `publish`: half of a beginning is nothing that anyone could read.
    """

    def __init__(self, path: Path, new: bool) -> None:
        self.path, self.published = path, not new
        self.below = JournaledFile.create(path.with_name(path.name + ".new")) if new else JournaledFile.resume(path)
        self.file = h5py.File(self.below, "w" if new else "r+", libver=HEADERS)
        known = self.file.id.get_mdc_config()
        known.set_initial_size = True
        known.initial_size = known.min_size = known.max_size = INDICES
        self.file.id.set_mdc_config(known)

    @property
    def descriptor(self) -> int:
        """Descriptor of the file, for rows that go to their places without HDF5."""
        return self.below.descriptor

    def publish(self) -> None:
        """Everything so far is whole: a new file gets its name."""
        if not self.published:
            self.flush()
            self.below.path.replace(self.path)
            self.below.journal(self.path)
            self.published = True

    def grow(self, columns: Iterable[Column], rows: int) -> None:
        """Make room for `rows` more rows of each of the columns."""
        columns = list(columns)
        for column in columns:
            column.resize(column.room + rows)
        self.flush()
        for column in columns:
            column.find_places(self.descriptor)

    def write_around(self, dataset: h5py.Dataset, values: np.ndarray) -> None:
        """Fill a dataset of fixed size; HDF5, and so the journal, need not see what nobody reads yet."""
        place = dataset.id.get_offset()
        if place is None or not self.published:
            dataset.id.write(h5py.h5s.ALL, h5py.h5s.ALL, values)
        else:
            written(self.below.descriptor, values.reshape(-1).view(np.uint8).data, place)

    def flush(self) -> None:
        """Make all that was written so far visible to readers in one change. Raises OSError if the disk is full."""
        h5py.h5f.flush(self.file.id)
        self.below.commit()

    def close(self) -> None:
        """Close the file with all changes, or as it was at the last flush if the disk is full."""
        try:
            self.file.close()
            self.below.commit()
        finally:
            self.below.close()


class Column:
    """A dataset whose rows have `height` entries of shape `shape` each, one row per stored frame or step.

    `sum` is the checksum of what was written last. Once there is room, rows are written to their `places` in the file,
    the bytes at which its chunks begin (-1: not known): HDF5 takes twenty times as long, and needs to know nothing of
    it. So it must keep no copies of chunks.
    """

    def __init__(
        self, group: h5py.Group, name: str, dtype: Any, height: int = 1, shape: tuple[int, ...] = (), together: int = 1
    ) -> None:
        self.height, self.shape = height, shape
        if name not in group:
            chunk = (max(1, height * together), *(max(1, n) for n in shape))
            plist = early()
            limits = (None, *(n or None for n in shape))  # chunks have to fit into them, also chunks of empty rows
            group.create_dataset(name, (0, *shape), maxshape=limits, dtype=dtype, chunks=chunk, dcpl=plist)
        # access to a dataset of which HDF5 keeps no chunks in memory
        uncached = h5py.h5p.create(h5py.h5p.DATASET_ACCESS)
        uncached.set_chunk_cache(0, 0, 1.0)
        self.dataset = h5py.Dataset(h5py.h5d.open(group.id, name.encode(), uncached))
        self.first = self.dataset.chunks[0]  # entries of a chunk
        self.dtype = self.dataset.dtype  # of a file that was begun with another one, that one
        self.sum = 0
        self.room = len(self.dataset) // max(1, height)
        self.places = NOWHERE
        self.descriptor = -1

    @property
    def row_bytes(self) -> int:
        """Size of one row in bytes."""
        return int(self.height * np.prod(self.shape, dtype=np.int64) * self.dtype.itemsize)

    def resize(self, rows: int) -> None:
        """Change the number of rows to `rows`."""
        self.places = NOWHERE
        self.dataset.id.set_extent((rows * self.height, *self.shape))
        self.room = rows

    def find_places(self, descriptor: int) -> None:
        """From here on write to the file with this descriptor, where HDF5 has allocated the chunks."""
        if self.dataset.chunks[1:] != self.shape or self.dataset.id.get_create_plist().get_nfilters():
            return
        first, self.descriptor = self.first, descriptor
        found = self.places = np.full(-(-len(self.dataset) // first), -1, np.int64)

        def note(chunk: Any) -> None:
            found[chunk.chunk_offset[0] // first] = chunk.byte_offset

        self.dataset.id.chunk_iter(note)

    def rows(self, begin: int, end: int) -> np.ndarray:
        """Read rows from `begin` to `end`."""
        return np.asarray(self.dataset[begin * self.height : end * self.height])

    def write(self, row: int, values: Any, rows: int = 1, around: bool = True) -> None:
        """Fill `rows` rows from `row` on, there must be room; not `around` HDF5: with the next change of the file."""
        size = (rows * self.height, *self.shape)
        data: Any = np.ascontiguousarray(values, self.dtype).reshape(size)
        self.sum = zlib.crc32(data)
        if data.size and not (around and len(self.places) and self._placed(row * self.height, data)):
            space = self.dataset.id.get_space()
            space.select_hyperslab((row * self.height, *(0 for _ in self.shape)), size)
            self.dataset.id.write(h5py.h5s.create_simple(size), space, data)

    def _placed(self, begin: int, data: np.ndarray) -> bool:
        """Write entries from `begin` on to their chunks; False if HDF5 does not know the place of a chunk."""
        first, end = self.first, begin + len(data)
        for chunk in range(begin // first, -(-end // first)):
            if self.places[chunk] < 0:
                return False
            low, high = max(begin, chunk * first), min(end, (chunk + 1) * first)
            part: Any = data[low - begin : high - begin]
            place = int(self.places[chunk]) + (low - chunk * first) * (data.nbytes // len(data))
            written(self.descriptor, part.reshape(-1).view(np.uint8).data, place)
        return True


class Number:
    """A whole number kept as an attribute, rewritten in place."""

    def __init__(self, owner: h5py.HLObject, name: str, start: int = 0) -> None:
        if name not in owner.attrs:
            owner.attrs[name] = np.int64(start)
        self.attribute = h5py.h5a.open(owner.id, name.encode())
        self._value = np.zeros((), np.int64)
        self.attribute.read(self._value)

    @property
    def value(self) -> int:
        """The number that was written last."""
        return int(self._value)

    def write(self, value: int) -> None:
        """Write another number in its place; the same one is there already."""
        if value != self._value:
            self._value[...] = value
            self.attribute.write(self._value)


def fixed(group: h5py.Group, name: str, shape: tuple[int, ...], dtype: Any) -> h5py.Dataset:
    """A dataset of fixed size whose space is allocated immediately."""
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return group.create_dataset(name, shape, dtype=dtype, dcpl=plist)


def early() -> Any:
    """Creation properties of a dataset whose space is allocated when it grows."""
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    plist.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    return plist
