"""`archive.sqlite`: every run and every cell that was made, kept so that nothing unchanged is run twice.

Each entry is committed on its own, so that a killed process loses what it was working on and nothing else.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from contactlab.api import Record
from contactlab.cases.record import from_bytes
from contactlab.errors import RequestError

FILE = "archive.sqlite"
CHOICES = ("case", "variant", "contact", "slave", "element", "integrator")
_TABLES = """
create table if not exists runs (
    key text, machine text, made text, name text, scene text, status text, reason text, work real, cpu_s real,
    record blob, primary key (key, machine));
create table if not exists cells (
    key text, machine text, made text, "case" text, variant text, contact text, slave text, element text,
    integrator text, verdict text, status text, reason text, cpu_s real, measures text, runs text,
    primary key (key, machine));
create table if not exists rows (
    key text, machine text, made text, scene text, name text, algorithm text, slave text, level integer, status text,
    reason text, cpu_s real, values_ text, toml text, primary key (key, machine));
"""
TABLES = ("runs", "cells", "rows")
_JSON = ("measures", "runs", "values_")


@dataclass(frozen=True)
class StoredRun:
    """A run as it is kept: `record` are the bytes of its record."""

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
    """A row of a comparison as it is kept: `values` are its measures by the columns of `table.csv`."""

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


class Archive:
    """An open archive. Reading never changes it; several processes may read while one writes."""

    def __init__(self, path: Path, write: bool = True) -> None:
        self.path = path
        try:
            self._file = sqlite3.connect(path if write else f"file:{path}?mode=ro", uri=not write, timeout=60.0)
            if write:
                self._file.execute("pragma journal_mode = wal")
                self._file.executescript(_TABLES)
            self._file.execute("select count(*) from runs").fetchone()
        except sqlite3.Error as error:
            raise RequestError(
                f"the archive cannot be read: {error}", where=str(path), allowed="archive.sqlite"
            ) from error

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *exception: object) -> None:
        self._file.close()

    def record(self, key: str, machine: str | None) -> Record | None:
        """The record of a run that was made before on this machine; on any one for None."""
        text = "select record from runs where key = ? and (? is null or machine = ?) order by made desc"
        found = self._file.execute(text, (key, machine, machine)).fetchone()
        return from_bytes(found[0]) if found else None

    def newest(self, name: str, scene: str) -> Record | None:
        """The newest record of a run by its name and its scene as TOML, whatever sources and machine made it."""
        text = "select record from runs where name = ? and scene = ? order by made desc"
        found = self._file.execute(text, (name, scene)).fetchone()
        return from_bytes(found[0]) if found else None

    def scene(self, key: str, machine: str) -> str:
        """The scene of a run as TOML; empty where there is no such run."""
        found = self._file.execute("select scene from runs where key = ? and machine = ?", (key, machine)).fetchone()
        return str(found[0]) if found else ""

    def add_run(self, run: StoredRun) -> None:
        """Keep a run."""
        end = (run.status, run.reason, run.work, run.cpu_s, run.record)
        self._insert("runs", (run.key, run.machine, _now(), run.name, run.scene, *end))

    def add_row(self, row: StoredRow) -> None:
        """Keep a row of a comparison."""
        head = (row.scene, row.name, row.algorithm, row.slave, row.level, row.status, row.reason)
        cost = row.values.get("cpu_s")
        text = json.dumps(row.values, default=str)
        self._insert("rows", (row.key, row.machine, _now(), *head, cost, text, row.toml))

    def add_cell(self, key: str, machine: str, choices: Mapping[str, str], found: Mapping[str, Any]) -> None:
        """Keep a cell: its verdict and its measures, and the keys of its runs."""
        head = [choices[name] for name in CHOICES]
        tail = [found[name] for name in ("verdict", "status", "reason", "cpu_s")]
        lists = [json.dumps(found[name]) for name in ("measures", "runs")]
        self._insert("cells", (key, machine, _now(), *head, *tail, *lists))

    def _insert(self, table: str, values: tuple[Any, ...]) -> None:
        with self._file:
            self._file.execute(f"insert or replace into {table} values ({', '.join('?' * len(values))})", values)

    def cell(self, key: str, machine: str) -> dict[str, Any] | None:
        """Read a cell that was made before on this machine."""
        return next(self._read("cells", "where key = ? and machine = ?", (key, machine)), None)

    def cells(self) -> Iterator[dict[str, Any]]:
        """Read all cells, the newest of each configuration first."""
        order = ", ".join(f'"{name}"' for name in CHOICES)
        return self._read("cells", f"order by {order}, made desc")

    def runs(self) -> Iterator[dict[str, Any]]:
        """Read all runs without their records, the newest first."""
        for run in self._read("runs", "order by made desc"):
            yield {name: value for name, value in run.items() if name != "record"}

    def rows(self) -> Iterator[dict[str, Any]]:
        """All rows of comparisons, the newest of each configuration first."""
        for row in self._read("rows", "order by scene, algorithm, slave, level, name, made desc"):
            yield {name.rstrip("_"): value for name, value in row.items()}

    def _read(self, table: str, rest: str = "", values: tuple[Any, ...] = ()) -> Iterator[dict[str, Any]]:
        if not self._has(table):
            return
        cursor = self._file.execute(f"select * from {table} {rest}", values)
        names = [column[0] for column in cursor.description]
        for row in cursor:
            found = dict(zip(names, row, strict=True))
            yield found | {name: json.loads(found[name]) for name in _JSON if name in found}

    def _has(self, table: str, file: str = "main") -> bool:
        text = f"select 1 from {file}.sqlite_master where type = 'table' and name = ?"
        return self._file.execute(text, (table,)).fetchone() is not None

    def take(self, other: Path) -> dict[str, int]:
        """Everything of another archive that is not there, or is newer there; how many of each table came."""
        with Archive(other, write=False):
            pass  # it is one, and readable
        came = {}
        self._file.execute("attach database ? as other", (str(other),))
        try:
            with self._file:
                for table in TABLES:
                    if not self._has(table, "other"):
                        continue  # made before this table was kept
                    before = self._file.total_changes
                    self._file.execute(
                        f"insert or replace into {table} select o.* from other.{table} o left join {table} m "
                        "on m.key = o.key and m.machine = o.machine where m.key is null or m.made < o.made"
                    )
                    came[table] = self._file.total_changes - before
        finally:
            self._file.execute("detach database other")
        return came


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
