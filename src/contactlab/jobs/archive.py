"""`archive.sqlite`: the records of runs, and the cells and rows that views made of them.

Each entry is committed on its own, so that a killed process loses what it was working on and nothing else. Each has a
checksum over all of its columns. An archive is checked when it is opened: damaged entries are named and left out, and
whoever writes renames the damaged file and continues with a copy of the sound entries.
"""

from __future__ import annotations

import json
import math
import sqlite3
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from contactlab.api import Record
from contactlab.errors import RequestError
from contactlab.jobs.record import from_bytes

FILE = "archive.sqlite"
CHOICES = ("case", "variant", "contact", "slave", "element", "integrator")
HEAD = ("key", "machine", "made")
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "runs": (*HEAD, "name", "scene", "status", "reason", "work", "cpu_s", "record"),
    "cells": (*HEAD, *CHOICES, "verdict", "status", "reason", "cpu_s", "measures", "runs"),
    "rows": (
        *HEAD, "scene", "name", "algorithm", "slave", "level", "status", "reason", "cpu_s", "values_", "toml",
    ),
}  # fmt: skip
"""Columns of each table, in this order, then the checksum. Text unless `KINDS` says otherwise."""
KINDS = {"work": "real", "cpu_s": "real", "level": "integer", "record": "blob"}
_JSON = ("measures", "runs", "values_")
_NAMES = {"runs": ("name",), "cells": CHOICES, "rows": ("scene", "name")}
"""Columns that identify an entry for people."""
BROKEN = (sqlite3.Error, UnicodeDecodeError, OverflowError)
"""Ends of a request to a damaged file; its messages may be damaged, too."""
_MOST = 100_000
"""Entries that are looked for one by one if a table cannot be listed."""


@dataclass(frozen=True)
class StoredRun:
    """A run as it is kept: `record` holds the bytes of its record."""

    key: str
    name: str
    scene: str
    status: str
    reason: str
    work: float
    cpu_s: float
    record: bytes
    machine: str


@dataclass(frozen=True)
class StoredRow:
    """A row of a comparison as it is kept: `values` holds its measures by the columns of `table.csv`."""

    key: str
    scene: str
    name: str
    algorithm: str
    slave: str
    level: int
    status: str
    reason: str
    values: Mapping[str, Any]
    toml: str
    machine: str


class _Place(NamedTuple):
    """Time at which an entry was made, and its row in the file."""

    made: str
    row: int


class Archive:
    """An open archive. Several processes may read while one writes.

    damage  what did not pass the check, in words; empty for a sound archive

    Raises RequestError if the file cannot be read as an archive; an unreadable file is renamed if `write`.
    """

    def __init__(self, path: Path, write: bool = True) -> None:
        self.path, self._write = path, write
        self.damage: list[str] = []
        self._places: dict[str, dict[tuple[str, str], _Place]] = {table: {} for table in COLUMNS}
        try:
            self._file = _connected(path, write)
            # older tables of runs have no checksums
            names = [row[1] for row in self._file.execute("pragma table_info(runs)")]
            if names and b"crc" not in names:
                self._file.close()
                raise RequestError(
                    "the archive was made by an earlier version, which kept no checksums", where=str(path),
                    hint="name another folder; what it held is run again",
                )  # fmt: skip
            self._check()
            if write:
                self._make_ready()
        except BROKEN as error:
            if not write:
                raise RequestError(
                    f"the archive cannot be read: {error}", where=str(path), allowed="archive.sqlite"
                ) from error
            self.damage.append(f"nothing of it can be read: {error}")
            with suppress(AttributeError, *BROKEN):
                self._file.close()
            self._put_aside()
            self._file = _connected(path, write)
            _prepare(self._file)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise RequestError(f"the archive cannot be written: {reason}", where=str(path)) from error

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; the last to write leaves it whole in one piece, without the journal that others read from."""
        if self._write:
            with suppress(*BROKEN):
                self._file.execute("pragma journal_mode = delete")
        self._file.close()

    # --- checking ----------------------------------------------------------------------------------

    def _check(self) -> None:
        """Verify the structure of the file and the checksum of each entry."""
        for (line,) in self._file.execute("pragma integrity_check(3)").fetchall():
            if line != b"ok":
                self.damage.append(f"structure: {_text(line)}")
        for table, columns in COLUMNS.items():
            for row, values in _entries(self._file, table, self.path.stat().st_size):
                if values is None or len(values) != len(columns) + 1:
                    self.damage.append(f"{table}: an entry cannot be read")
                elif values[-1] != checksum(table, values[:-1]):
                    self.damage.append(f"{table}: {_named(table, values)}")
                else:
                    key, machine, made = (_text(value) for value in values[:3])
                    self._places[table][key, machine] = _Place(made, row)

    def _make_ready(self) -> None:
        """Prepare the file for writing; a damaged one is renamed, and a new one has all sound entries."""
        try:
            _prepare(self._file)
        except BROKEN as error:
            self.damage.append(f"it cannot be written: {error}")
        if not self.damage:
            return
        fresh = self.path.with_name(f"{self.path.name}.new")
        for end in ("", "-wal", "-shm"):
            fresh.with_name(fresh.name + end).unlink(missing_ok=True)
        with _connected(fresh, write=True) as file:
            _prepare(file)
            for table, places in self._places.items():
                for name, place in list(places.items()):
                    values = self._values(table, place.row)
                    if values is not None:
                        places[name] = _Place(place.made, _inserted(file, table, values))
        file.close()
        self._file.close()
        self._put_aside()
        fresh.rename(self.path)
        self._file = _connected(self.path, write=True)

    def _put_aside(self) -> None:
        number = 1
        while (aside := self.path.with_name(f"{self.path.name}.damaged-{number}")).exists():
            number += 1
        self.path.rename(aside)
        for end in ("-wal", "-shm"):
            self.path.with_name(self.path.name + end).unlink(missing_ok=True)
        self.damage.append(f"the damaged file is kept as {aside.name}")

    # --- reading -----------------------------------------------------------------------------------

    def record(self, key: str, machine: str | None) -> Record | None:
        """The record of a run that was made before on this machine; on any one for None."""
        found = [place for (own, at), place in self._places["runs"].items() if own == key and machine in (None, at)]
        entry = self._entry("runs", max(found).row) if found else None
        return None if entry is None else from_bytes(entry["record"])

    def newest(self, name: str, scene: str) -> Record | None:
        """The newest record of a run by its name and its scene as TOML, whatever sources and machine made it."""
        for place in sorted(self._places["runs"].values(), reverse=True):
            entry = self._entry("runs", place.row)
            if entry is not None and entry["name"] == name and entry["scene"] == scene:
                return from_bytes(entry["record"])
        return None

    def scene(self, key: str, machine: str) -> str:
        """The scene of a run as TOML; empty if there is no such run."""
        place = self._places["runs"].get((key, machine))
        entry = None if place is None else self._entry("runs", place.row)
        return "" if entry is None else str(entry["scene"])

    def cell(self, key: str, machine: str) -> dict[str, Any] | None:
        """Read a cell that was made before on this machine."""
        place = self._places["cells"].get((key, machine))
        return None if place is None else self._entry("cells", place.row)

    def cells(self) -> Iterator[dict[str, Any]]:
        """Read all cells, the newest of each configuration first."""
        yield from sorted(self._all("cells"), key=lambda cell: [cell[name] for name in CHOICES])

    def runs(self) -> Iterator[dict[str, Any]]:
        """Read all runs without their records, the newest first."""
        for run in self._all("runs"):
            yield {name: value for name, value in run.items() if name != "record"}

    def rows(self) -> Iterator[dict[str, Any]]:
        """All rows of comparisons, the newest of each configuration first."""
        order = ("scene", "algorithm", "slave", "level", "name")
        for row in sorted(self._all("rows"), key=lambda row: [row[name] for name in order]):
            yield {name.rstrip("_"): value for name, value in row.items()}

    def _all(self, table: str) -> Iterator[dict[str, Any]]:
        """Entries of a table, the newest first."""
        for place in sorted(self._places[table].values(), reverse=True):
            entry = self._entry(table, place.row)
            if entry is not None:
                yield entry

    def _entry(self, table: str, row: int) -> dict[str, Any] | None:
        """Columns of an entry by name; None if it was damaged since the archive was opened."""
        values = self._values(table, row)
        if values is None:
            return None
        found = {name: value if KINDS.get(name) else _text(value) for name, value in zip(COLUMNS[table], values)}  # noqa: B905
        return found | {name: json.loads(found[name]) for name in _JSON if name in found}

    def _values(self, table: str, row: int) -> tuple[Any, ...] | None:
        values = _read(self._file, table, row)
        return values[:-1] if values is not None and values[-1] == checksum(table, values[:-1]) else None

    # --- writing -----------------------------------------------------------------------------------

    def add_run(self, run: StoredRun) -> None:
        """Keep a run."""
        end = (run.status, run.reason, run.work, run.cpu_s, run.record)
        self._insert("runs", (run.key, run.machine, _now(), run.name, run.scene, *end))

    def add_row(self, row: StoredRow) -> None:
        """Keep a row of a comparison."""
        head = (row.scene, row.name, row.algorithm, row.slave, row.level, row.status, row.reason)
        text = json.dumps(row.values, default=str)
        self._insert("rows", (row.key, row.machine, _now(), *head, row.values.get("cpu_s"), text, row.toml))

    def add_cell(self, key: str, machine: str, choices: Mapping[str, str], found: Mapping[str, Any]) -> None:
        """Keep a cell: its verdict and its measures, and the keys of its runs."""
        head = [choices[name] for name in CHOICES]
        tail = [found[name] for name in ("verdict", "status", "reason", "cpu_s")]
        lists = [json.dumps(found[name]) for name in ("measures", "runs")]
        self._insert("cells", (key, machine, _now(), *head, *tail, *lists))

    def _insert(self, table: str, values: Sequence[Any]) -> None:
        plain = tuple(_plain(name, value) for name, value in zip(COLUMNS[table], values, strict=True))
        with self._file:
            row = _inserted(self._file, table, plain)
        key, machine, made = (_text(value) for value in plain[:3])
        self._places[table][key, machine] = _Place(made, row)

    def take(self, other: Path) -> tuple[dict[str, int], list[str]]:
        """Copy what another archive has and this one lacks, or has older.

        Returns how many entries of each table came, and the damage of the other archive.
        """
        came = {}
        with Archive(other, write=False) as source:
            for table, places in source._places.items():
                before = self._places[table]
                newer = {n: p for n, p in places.items() if n not in before or before[n].made < p.made}
                came[table] = 0
                for place in newer.values():
                    values = source._values(table, place.row)
                    if values is not None:
                        self._insert(table, values)
                        came[table] += 1
            return came, source.damage


def in_words(damage: Sequence[str]) -> str:
    """A line for the damage of an archive."""
    more = f"; and {len(damage) - 6} more" if len(damage) > 6 else ""
    return f"parts of the archive are damaged: {'; '.join(damage[:6])}{more}"


def checksum(table: str, values: Sequence[Any]) -> int:
    """CRC-32 of the columns of an entry, text as UTF-8."""
    made = zlib.crc32(table.encode())
    for value in values:
        if value is None:
            data = b"n"
        elif isinstance(value, int):
            data = struct.pack("<cq", b"i", value)
        elif isinstance(value, float):
            data = struct.pack("<cd", b"f", value)
        else:
            data = struct.pack("<cq", b"s", len(value)) + value
        made = zlib.crc32(data, made)
    return made


def _plain(column: str, value: Any) -> Any:
    """A value as the file gives it back: text as bytes, no number that is not finite."""
    kind = KINDS.get(column)
    if kind == "real":
        return float(value) if value is not None and math.isfinite(value) else None
    if kind == "integer":
        return int(value)
    return value if isinstance(value, bytes) else str(value).encode(errors="replace")


def _connected(path: Path, write: bool) -> sqlite3.Connection:
    """Open the file; all text comes as bytes, so that the check sees what is stored."""
    place = f"file:{quote(str(path.absolute()))}"
    file = sqlite3.connect(f"{place}?mode={'rwc' if write else 'ro'}", uri=True, timeout=60.0)
    file.text_factory = bytes
    try:
        file.execute("select count(*) from sqlite_master").fetchone()
    except BROKEN:
        if write:
            raise
        # a folder that cannot be written has no room for what readers share with writers
        file = sqlite3.connect(f"{place}?mode=ro&immutable=1", uri=True)
        file.text_factory = bytes
        file.execute("select count(*) from sqlite_master").fetchone()
    return file


def _prepare(file: sqlite3.Connection) -> None:
    """Make the tables that are not there; writes in any case, so that a file that takes nothing is found out."""
    file.execute("pragma journal_mode = wal")
    for table, columns in COLUMNS.items():
        listed = ", ".join(f'"{name}" {KINDS.get(name, "text")}' for name in columns)
        file.execute(f"create table if not exists {table} ({listed}, crc integer, primary key (key, machine))")
    file.execute("pragma user_version = 2")


def _entries(file: sqlite3.Connection, table: str, size: int) -> Iterator[tuple[int, tuple[Any, ...] | None]]:
    """Numbers and columns of all rows of a table, None for one that cannot be read; `size` of the file in bytes."""
    try:
        rows = [row for (row,) in file.execute(f"select rowid from {table} order by rowid")]
        listed = True
    except BROKEN as error:
        if str(error) == f"no such table: {table}":
            return  # nothing of that kind was kept yet
        rows, listed = list(range(1, min(size // 64, _MOST))), False
    for row in rows:
        values = _read(file, table, row)
        if values is not None or listed:
            yield row, values


def _read(file: sqlite3.Connection, table: str, row: int) -> tuple[Any, ...] | None:
    try:
        found = file.execute(f"select * from {table} where rowid = ?", (row,)).fetchone()
    except BROKEN:
        return None
    return None if found is None else tuple(found)


def _inserted(file: sqlite3.Connection, table: str, values: Sequence[Any]) -> int:
    """Write an entry with its checksum; returns the number of its row."""
    stored = [
        value.decode() if isinstance(value, bytes) and name not in KINDS else value
        for name, value in zip(COLUMNS[table], values, strict=True)
    ]
    marks = ", ".join("?" * (len(values) + 1))
    done = file.execute(f"insert or replace into {table} values ({marks})", (*stored, checksum(table, values)))
    return int(done.lastrowid or 0)


def _named(table: str, values: Sequence[Any]) -> str:
    """Name of a damaged entry, as far as that can be read."""
    found = dict(zip(COLUMNS[table], values))  # noqa: B905
    return " ".join(filter(None, (_text(found[name]) for name in _NAMES[table])))


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
