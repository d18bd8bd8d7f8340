"""The memory that a mesh will take, and the memory that there is."""

from __future__ import annotations

import math
import os
from pathlib import Path

NODE_BYTES = 700.0  # of a model, per node: 741 MiB were measured for a million, libraries included
FILE_BYTES = 4.0  # that a byte of a mesh file takes once read, at least: texts of ten bytes become numbers of eight


def machine_memory() -> float:
    """Bytes of memory that this process may use: of the machine, or of the group that it runs in."""
    try:
        total = float(os.sysconf("SC_PHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf
    for name in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            total = min(total, float(Path(name).read_text()))
        except (OSError, ValueError):
            continue  # no such group, or no limit ("max")
    return total


def in_words(size: float) -> str:
    """Bytes in words; in MiB below a tenth of a GiB."""
    return f"{size / 2.0**30:.3g} GiB" if size >= 0.1 * 2.0**30 or size == 0.0 else f"{size / 2.0**20:.3g} MiB"


def check_file_size(path: Path) -> None:
    """Raise ValueError if a mesh file is larger than this machine can hold once it is read."""
    size, limit = FILE_BYTES * path.stat().st_size, machine_memory()
    if size > limit:
        raise ValueError(f"path: got {path.name}: about {in_words(size)}, allowed: what fits into {in_words(limit)}")


def check_number(got: str, cells: float, level: int) -> None:
    """Raise ValueError if a mesh of so many cells at level 1 is more than this machine can hold at `level`.

    got  the key and its value, "cells: got [4, 2]"
    """
    number = cells * float(level) ** 2
    size, limit = NODE_BYTES * number, machine_memory()
    if size > limit:
        raise ValueError(
            f"{got} at level {level}, {number:.3g} cells: about {in_words(size)}, "
            f"allowed: what fits into {in_words(limit)}"
        )
