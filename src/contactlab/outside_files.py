"""Files that somebody else may have written, looked at before they are read: what they are, how large, and unpacked."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from contactlab.errors import RequestError, Where

TEXT = 64 << 20  # bytes of a text that is read, unpacked: a million rows of a table, a thousand times any scene
UNPACKERS = {".gz": "gzip", ".bz2": "bz2", ".xz": "lzma"}
GROWTH, SPARE = 100.0, float(512 << 20)  # bytes that a byte of a mesh file may take while it is read, and extra bytes


LONGEST = 255  # bytes of a name of a file or folder


def usable(path: Path, where: Where) -> Path:
    """Return the path. Raises RequestError if no file can have this name."""
    for part in path.parts:
        try:
            size = len(part.encode())
        except UnicodeEncodeError:
            size = 0
        if not 0 < size <= LONGEST or "\0" in part:
            got = part if 0 < size <= LONGEST else f"{part[:40]}... of {len(part)} characters"
            raise RequestError(
                "no file can have this name",
                where=where,
                got=got,
                allowed=f"up to {LONGEST} bytes of UTF-8 without NUL",
            )
    return path


def read_outside(
    path: Path, where: Where, allowed: str, most: int = TEXT, kind: type[RequestError] = RequestError
) -> bytes:
    """The content of a file, unpacked where its name says that it is packed. Raises an error of this kind."""
    try:
        # opening a pipe that nobody writes to would block: it is opened without waiting, and checked afterwards
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        try:
            _check(os.fstat(descriptor), path, where, allowed, most, kind)
            name = UNPACKERS.get(path.suffix.lower())
            with os.fdopen(descriptor, "rb", closefd=False) as file:
                content = (file if name is None else import_module(name).open(file)).read(most + 1)
        finally:
            os.close(descriptor)
    except RequestError:
        raise
    except Exception as error:  # each unpacker has exceptions of its own
        reason = str(getattr(error, "strerror", None) or error).lower()
        raise kind(f"the file cannot be read: {reason}", where=where, got=str(path), allowed=allowed) from error
    if len(content) > most:
        got = f"{path}: more than {most >> 20} MiB when it is unpacked"
        raise kind("the file is too large", where=where, got=got, allowed=allowed)
    return content


def text_outside(
    path: Path, where: Where, allowed: str, most: int = TEXT, kind: type[RequestError] = RequestError
) -> str:
    """The same as a string."""
    try:
        return read_outside(path, where, allowed, most, kind).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise kind("the file is not text in UTF-8", where=where, got=str(path), allowed=allowed) from error


def _check(found: os.stat_result, path: Path, where: Where, allowed: str, most: float, kind: Any) -> None:
    if stat.S_ISDIR(found.st_mode):
        raise kind("this is a folder", where=where, got=str(path), allowed=allowed)
    if not stat.S_ISREG(found.st_mode):
        problem = "not a file: a device or a pipe may never end"
        raise kind(problem, where=where, got=str(path), allowed=allowed)
    if found.st_size > most:
        got = f"{path}: {found.st_size / 2.0**20:.4g} MiB"
        raise kind("the file is too large", where=where, got=got, allowed=f"{allowed}, up to {most / 2.0**20:.4g} MiB")


@contextmanager
def bounded_memory(size: float) -> Iterator[None]:
    """While it is entered, reading a file of so many bytes may not take the memory that a bomb takes: MemoryError."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError, ValueError):
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = int(pages * resource.getpagesize() + GROWTH * size + SPARE)
    resource.setrlimit(resource.RLIMIT_AS, (wanted if soft == resource.RLIM_INFINITY else min(soft, wanted), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
