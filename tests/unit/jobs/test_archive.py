"""The archive is checked when it is opened: a flipped bit anywhere changes no number in silence."""

from __future__ import annotations

import random
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from contactlab.cli import main
from contactlab.errors import RequestError
from contactlab.jobs.archive import CHOICES, FILE, Archive, StoredRow, StoredRun

FLIPS = 20
"""Of 500 that were tried; the others are made by `make test FULL=1`."""


def fill(path: Path, count: int = 12) -> None:
    chance = random.Random(1)
    with Archive(path) as archive:
        for k in range(count):
            record = chance.randbytes(chance.randrange(300, 6000))
            archive.add_run(StoredRun(f"key{k}", f"name {k}", "level = 1\n" * 20, "finished", "", k, 0.1, record, "m"))
            values = {"reaction": 5.05e-29, "cpu_s": 0.1, "missing": None}
            archive.add_row(
                StoredRow(f"row{k}", "disc", f"n{k}", "p0", "disc", 1, "finished", "", values, "x = 1\n", "m")
            )
            found = {"verdict": "met", "status": "finished", "reason": "", "cpu_s": 0.1, "measures": [{"a": 1.5}]}
            archive.add_cell(f"cell{k}", "m", dict.fromkeys(CHOICES, f"x{k}"), {**found, "runs": ["key"]})


def contents(archive: Archive) -> list[str]:
    """All that can be read, as texts."""
    found = [*archive.cells(), *archive.runs(), *archive.rows()]
    return [str(one) for one in found] + [str(archive._values("runs", p.row)) for p in archive._places["runs"].values()]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("archive") / FILE
    fill(path)
    return path


def flipped(data: bytes, number: int, chance: random.Random) -> bytes:
    """The first flips fall into the header and the schema, where most depends on each bit."""
    damaged = bytearray(data)
    at = chance.randrange(200) if number % 4 == 0 else chance.randrange(len(damaged))
    damaged[at] ^= 1 << chance.randrange(8)
    return bytes(damaged)


@pytest.mark.parametrize("flips", [FLIPS, pytest.param(500, marks=pytest.mark.full)])
def test_a_flipped_bit_is_told_or_without_effect(sound: Path, flips: int, tmp_path: Path) -> None:
    data, chance = sound.read_bytes(), random.Random(flips)
    with Archive(sound, write=False) as archive:
        whole = contents(archive)
        assert not archive.damage
    path = tmp_path / FILE
    for number in range(flips):
        path.write_bytes(flipped(data, number, chance))
        try:
            with Archive(path, write=False) as archive:
                found, damage = contents(archive), archive.damage
        except RequestError:
            found, damage = [], ["refused"]
        assert set(found) <= set(whole), number
        assert damage or found == whole, number
        # whoever writes goes on with what is sound
        with Archive(path) as archive:
            assert set(contents(archive)) <= set(whole)
            archive.add_run(StoredRun("new", "new", "s", "finished", "", 1, float("nan"), b"x", "m"))
        with Archive(path, write=False) as archive:
            assert not archive.damage
            assert archive.scene("new", "m") == "s"
        for left in tmp_path.iterdir():
            left.unlink()


def test_a_damaged_number_is_no_number(sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = bytearray(sound.read_bytes())
    at = data.index(b'"reaction": 5') + len(b'"reaction": ')
    data[at] ^= 4
    (tmp_path / FILE).write_bytes(data)
    for words in (["export"], ["list"], ["merge", str(tmp_path / "new"), str(tmp_path)]):
        with Archive(tmp_path / "new"):
            pass
        told = [str(tmp_path)] if len(words) == 1 else []
        assert main(["archive", *words, *told]) == 1
        out, err = capsys.readouterr()
        assert "damaged: rows: disc n" in err
        assert "1.05e-29" not in out
        assert "Traceback" not in err


def test_what_is_no_archive_is_put_aside_by_who_writes(tmp_path: Path) -> None:
    path = tmp_path / FILE
    path.write_text("precious")
    with pytest.raises(RequestError, match="cannot be read"):
        Archive(path, write=False)
    with Archive(path) as archive:
        assert "nothing of it can be read" in archive.damage[0]
    assert (tmp_path / f"{FILE}.damaged-1").read_text() == "precious"


def test_an_archive_without_checksums_is_refused(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / FILE) as file:
        file.execute("create table runs (key text, machine text, primary key (key, machine))")
    file.close()
    for write in (False, True):
        with pytest.raises(RequestError, match="earlier version"):
            Archive(tmp_path / FILE, write)


def test_newer_entries_come_from_another_archive(sound: Path, tmp_path: Path) -> None:
    def made(path: Path) -> list[Any]:
        with Archive(path, write=False) as archive:
            return contents(archive)

    mine, other = tmp_path / FILE, tmp_path / "other.sqlite"
    fill(other, 3)
    with Archive(mine) as archive:
        assert archive.take(other) == ({"runs": 3, "cells": 3, "rows": 3}, [])
        assert archive.take(other) == ({"runs": 0, "cells": 0, "rows": 0}, [])
    assert len(made(mine)) == len(made(other)) == 12


def test_a_folder_that_cannot_be_written_can_be_read(sound: Path) -> None:
    with Archive(sound, write=False) as archive:
        archive._file.close()
    (folder := sound.parent).chmod(0o500)
    try:
        with Archive(sound, write=False) as archive:
            assert len(list(archive.runs())) == 12
    finally:
        folder.chmod(0o700)


def test_a_closed_archive_is_one_file(tmp_path: Path) -> None:
    """What is copied to another machine is whole, also after others have read it."""
    for write in (True, False):
        with Archive(tmp_path / FILE, write=write):
            pass
    assert [path.name for path in tmp_path.iterdir()] == [FILE]
