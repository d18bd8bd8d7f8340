"""Rows of a comparison, put into the archive of its folder as their runs end."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from contactlab.archive.archive import FILE, Archive, StoredRow
from contactlab.archive.keys import row_key
from contactlab.scene.scene import Scene
from contactlab.studies.table import Row


class RowKeeper:
    """Keeps rows in the archive of `folder`; where there is no folder, nothing. Opened by the first row."""

    def __init__(self, folder: str | Path | None) -> None:
        self._path = None if folder is None else Path(folder) / FILE
        self._archive: Archive | None = None

    def __enter__(self) -> RowKeeper:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._archive is not None:
            self._archive.__exit__()

    def keep(self, row: Row, scene: Scene, machine: str) -> None:
        """Put one row into the archive, committed on its own."""
        if self._path is None:
            return
        if self._archive is None:
            self._archive = Archive(self._path)
        self._archive.add_row(_stored(row, scene, machine))


def _stored(row: Row, scene: Scene, machine: str) -> StoredRow:
    ends = (row.algorithm, row.slave, row.level, row.status, row.reason)
    values: dict[str, Any] = {name: _number(value) for name, value in row.record().items()}
    return StoredRow(row_key(scene, row.name), scene.name, row.name, *ends, values, scene.toml(), machine)


def _number(value: object) -> object:
    """As JSON has it: nothing for a number that is missing."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
