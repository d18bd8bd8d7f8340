"""A file that grows is whole after each of the writes that change it, and when the disk takes no more."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from contactlab.results import journaled
from contactlab.results.growing import Column, GrowingFile
from contactlab.results.journaled import JournaledFile, journal_of

ROWS = 40


def grow(path: Path, seen: Callable[[int], None] = lambda rows: None) -> None:
    """Rows are added, room is made several times, a text is replaced; `seen` is called when rows are in sight."""
    growing = GrowingFile(path, new=True)
    tables = [Column(growing.file, name, "f8", 1, (3,), 2) for name in ("a", "b")]
    growing.file.attrs["count"] = 0
    growing.publish()
    for row in range(ROWS):
        if row >= tables[0].room:
            growing.grow(tables, max(4, row))
        for table in tables:
            table.write(row, np.full(3, row + 1.0))
        growing.file.attrs["count"] = row + 1
        if not row % 7:
            growing.file.attrs.create("text", "x" * (row + 1), dtype=h5py.string_dtype(length=row + 1))
        growing.flush()
        seen(row + 1)
    for table in tables:
        table.resize(ROWS)
    growing.close()


def rows_in(path: Path) -> int:
    """Rows in sight of a file, all of them whole."""
    over = JournaledFile.read_only(path)
    with h5py.File(path if over is None else over, "r") as file:
        count = int(file.attrs["count"])
        for name in ("a", "b"):
            assert np.array_equal(file[name][:count, 0], np.arange(1.0, count + 1.0))
    return count


@pytest.mark.full
def test_a_kill_between_any_two_writes_leaves_a_whole_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, killed, write = tmp_path / "file", tmp_path / "killed", os.pwrite
    known, tried, journals, looking = [0], [0], [0], list[bool]()

    def write_and_look(descriptor: int, data: Any, offset: int) -> int:
        count = write(descriptor, data, offset)
        if path.exists() and not looking:
            looking.append(True)
            for place in (path, journal_of(path)):
                shutil.copyfile(place, killed.with_name(place.name.replace("file", "killed")))
            assert rows_in(killed) in (known[-1], known[-1] + 1)
            journals[0] += JournaledFile.read_only(killed) is not None
            continued = JournaledFile.resume(killed)
            continued.close()
            assert rows_in(killed) in (known[-1], known[-1] + 1)
            tried[0] += 1
            looking.clear()
        return count

    monkeypatch.setattr(journaled.os, "pwrite", write_and_look)
    grow(path, known.append)
    assert rows_in(path) == ROWS
    assert tried[0] > 4 * ROWS
    assert journals[0] > ROWS
    assert not journal_of(path).exists()


def test_a_full_disk_leaves_what_was_in_sight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write, left, known = os.pwrite, [0], [0]

    def full(descriptor: int, data: Any, offset: int) -> int:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(descriptor, data, offset)

    monkeypatch.setattr(journaled.os, "pwrite", full)
    for writes in range(40, 230, 5):
        left[0], known[:] = writes, [0]
        path = tmp_path / f"file-{writes}"
        with pytest.raises(OSError, match="No space left"):
            grow(path, known.append)
        left[0] = 10**9
        assert not path.exists() or rows_in(path) in (known[-1], known[-1] + 1)


def test_no_link_is_followed(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_bytes(b"mine")
    (tmp_path / "file.new").symlink_to(victim)
    GrowingFile(tmp_path / "file", new=True).close()
    (tmp_path / "linked").symlink_to(tmp_path / "file.new")
    with pytest.raises(OSError, match="symbolic links"):
        GrowingFile(tmp_path / "linked", new=False)
    assert victim.read_bytes() == b"mine"
