"""File locks: of two processes that need the same kernel, one compiles it; the other waits and loads the result."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

try:
    import fcntl
except ImportError:  # Windows: both compile, the later result overwrites the other
    fcntl = None  # type: ignore[assignment]

_held = threading.local()


def lock_file(dispatcher: Any) -> Path | None:
    """Return the file to lock for a kernel, next to its machine code; None for a kernel that is not cached on disk."""
    folder, function = dispatcher.stats.cache_path, dispatcher.py_func
    stem = f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}"
    return Path(folder) / f"{stem}.lock" if folder else None


@contextmanager
def kernel_locked(dispatcher: Any, wait: bool = True) -> Iterator[bool]:
    """Hold the lock of a kernel. Yields whether it was acquired; with `wait`, it waits until it is.

    Nothing is locked inside the lock of another kernel, or if files cannot be locked: kernels that a kernel calls
    are compiled under numba's own lock, and to wait there for another thread could be a deadlock.
    """
    path = None if getattr(_held, "any", False) or fcntl is None else lock_file(dispatcher)
    file = _opened(path)
    if file is None:
        yield True
        return
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:  # held by another process, or a file system without locks
            yield wait
            return
        _held.any = True
        try:
            yield True
        finally:
            _held.any = False  # closing the file releases the lock


def free_place(folder: Path, places: int) -> IO[str] | None:
    """Lock one of `places` files in a folder shared by all processes of this machine; None if all are taken.

    The lock is released when the returned file is closed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(places if fcntl is not None else 0):
        file = _opened(folder / f"place-{number}.lock")
        if file is None:
            return None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.close()
        else:
            return file
    return None


def _opened(path: Path | None) -> IO[str] | None:
    try:
        return None if path is None else path.open("a")
    except OSError:  # a cache that cannot be written
        return None
