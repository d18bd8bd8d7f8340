"""A file below HDF5 that changes whole or not at all, whenever its process is killed or its disk is full.

HDF5 rewrites headers in many places and in an order of its own: a process that is killed in between leaves a file that
nobody can read, and an error of a write inside the library can crash it. So the library writes into memory; `commit`
puts all of it into a journal, and then to its places. A journal that is whole is applied again by whoever continues
the file, and read over by whoever reads it.
"""

from __future__ import annotations

import errno
import os
import struct
import zlib
from pathlib import Path
from typing import Any

MAGIC = b"contactlab journal 2\n\0\0\0"
HEADER = struct.Struct("<24sQQQ")  # magic, bytes of the entries, size of the file, checksum of the entries and of these
ENTRY = struct.Struct("<QQ")  # offset, bytes
NO_LINK = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)

UNSUPPORTED = (errno.EOPNOTSUPP, errno.EINVAL)

Writes = list[tuple[int, bytes]]


def journal_of(path: Path) -> Path:
    """Path of the journal of a file while the file is open, and after a kill."""
    return path.with_name(path.name + ".journal")


class JournaledFile:
    """File object for h5py. `writes` and `size` are not on the disk before `commit`.

    A new file is written directly, since nobody reads it, until it has its name and `journal` is called.
    """

    def __init__(self, path: Path, flags: int, writes: Writes | None = None) -> None:
        self.path, self.place = path, 0
        self.descriptor = os.open(path, flags | NO_LINK, 0o666)
        self.writes: Writes = writes or []
        self.size = os.fstat(self.descriptor).st_size
        self.log: int | None = None

    @classmethod
    def create(cls, path: Path) -> JournaledFile:
        """Begin a file; one that is there is removed, and a link as well."""
        path.unlink(missing_ok=True)
        return cls(path, os.O_RDWR | os.O_CREAT | os.O_EXCL)

    @classmethod
    def resume(cls, path: Path) -> JournaledFile:
        """Continue a file, with what a killed process had in its journal."""
        made = cls(path, os.O_RDWR)
        if (left := read_journal(path)) is not None:
            made.writes, made.size = left
            made._apply()
        made.journal(path)
        return made

    @classmethod
    def read_only(cls, path: Path) -> JournaledFile | None:
        """A file with an unapplied journal read over it; None if it has no journal."""
        left = read_journal(path)
        if left is None:
            return None
        made = cls(path, os.O_RDONLY, left[0])
        made.size = left[1]
        return made

    def journal(self, path: Path) -> None:
        """From here on changes are whole or none; the file is at `path` now."""
        self.path = path
        place = journal_of(path)
        place.unlink(missing_ok=True)
        self.log = os.open(place, os.O_RDWR | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666)

    def commit(self) -> None:
        """Write all changes. Raises OSError, before anything is changed, if the disk has no space for them."""
        if not self.writes and self.size == os.fstat(self.descriptor).st_size:
            return
        self._reserve(os.fstat(self.descriptor).st_size)
        if self.log is not None and not self._is_one_page():
            entries = b"".join(part for offset, data in self.writes for part in (ENTRY.pack(offset, len(data)), data))
            written(self.log, entries, HEADER.size)
            written(self.log, _header(entries, self.size), 0)
        self._apply()
        if self.log is not None:
            written(self.log, bytes(HEADER.size), 0)

    def close(self) -> None:
        """Close the file. What was not committed is dropped; what was, and found no room, stays in the journal."""
        os.close(self.descriptor)
        if self.log is not None:
            os.close(self.log)
            if read_journal(self.path) is None:
                journal_of(self.path).unlink(missing_ok=True)

    def _is_one_page(self) -> bool:
        """Return whether the system makes the change atomically."""
        return len(self.writes) == 1 and self.writes[0][0] // 512 == (self.writes[0][0] + len(self.writes[0][1])) // 512

    def _reserve(self, present: int) -> None:
        """Take the room that the file grows by: rows are written to it later, and must find it."""
        if self.size <= present:
            return
        try:
            os.posix_fallocate(self.descriptor, present, self.size - present)
        except AttributeError:
            return
        except OSError as error:
            if error.errno not in UNSUPPORTED:
                raise OSError(error.errno, os.strerror(error.errno or 0), str(self.path)) from error

    def _apply(self) -> None:
        for offset, data in self.writes:
            written(self.descriptor, data, offset)
        if os.fstat(self.descriptor).st_size != self.size:
            os.ftruncate(self.descriptor, self.size)
        self.writes = []

    # --- what h5py calls; nothing of it fails, for the library would not survive that ---------------

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place in the file."""
        self.place = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self.place, os.SEEK_END: self.size}[whence]
        return self.place

    def tell(self) -> int:
        """The present place."""
        return self.place

    def readinto(self, buffer: Any) -> int:
        """Read what is there, with changes that are not committed yet."""
        target, begin = memoryview(buffer).cast("B"), self.place
        end = min(begin + len(target), self.size)
        found = os.pread(self.descriptor, max(0, end - begin), begin)
        target[: len(found)] = found
        target[len(found) :] = bytes(len(target) - len(found))
        for offset, data in self.writes:
            low, high = max(begin, offset), min(end, offset + len(data))
            if low < high:
                target[low - begin : high - begin] = data[low - offset : high - offset]
        self.place = begin + len(target)
        return len(target)

    def read(self, size: int) -> bytes:
        """Read so many bytes."""
        data = bytearray(size)
        self.readinto(data)
        return bytes(data)

    def write(self, data: Any) -> int:
        """Change bytes from the present place on."""
        content = bytes(data)
        if self.writes and self.writes[-1][0] == self.place and len(self.writes[-1][1]) == len(content):
            self.writes.pop()  # the same header once more
        self.writes.append((self.place, content))
        self.place += len(content)
        self.size = max(self.size, self.place)
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        self.size = self.place if size is None else size
        return self.size

    def flush(self) -> None:
        """Do nothing: `commit` writes."""


def read_journal(path: Path) -> tuple[Writes, int] | None:
    """Return the writes that a killed process was about to make and the size of its file; None if there are none."""
    try:
        with os.fdopen(os.open(journal_of(path), os.O_RDONLY | NO_LINK), "rb") as file:
            head = file.read(HEADER.size)
            if len(head) < HEADER.size:
                return None
            magic, length, size, _ = HEADER.unpack(head)
            entries = file.read(length) if magic == MAGIC and length <= os.fstat(file.fileno()).st_size else b""
    except OSError:
        return None
    if _header(entries, size) != head:
        return None
    writes, at = [], 0
    while at < len(entries):
        offset, count = ENTRY.unpack_from(entries, at)
        at += ENTRY.size
        writes.append((offset, entries[at : at + count]))
        at += count
    return writes, size


def _header(entries: bytes, size: int) -> bytes:
    return HEADER.pack(MAGIC, len(entries), size, zlib.crc32(entries, zlib.crc32(ENTRY.pack(len(entries), size))))


def written(descriptor: int, data: bytes | memoryview, offset: int) -> None:
    """Write all of `data`. Raises OSError if the disk is full."""
    view = memoryview(data)
    while view:
        count = os.pwrite(descriptor, view, offset)
        view, offset = view[count:], offset + count
