"""The text files that a run leaves: history.csv, iterations.csv, contact.csv, summary.json, scene.toml."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api.frame import IterationRow
from contactlab.errors import RequestError
from contactlab.results.results import ContactCurve, ContactHistory

ITERATIONS = "iterations.csv"


class HistoryFile:
    """`history.csv`, a row per stored frame. While it is open, no other run may write to the folder.

    Raises RequestError if another run has it open, or if nothing can be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            self.file = (folder / "history.csv").open("a", newline="")
        except OSError as error:
            raise _unwritable(folder, error) from error
        _claim(self.file, folder)
        self.writer: csv.DictWriter[str] | None = None

    def replace_rows(self, rows: Sequence[Mapping[str, float]]) -> None:
        """Replace the content of the file by these rows."""
        self.file.truncate(0)
        for row in rows:
            self.add(row)

    def add(self, row: Mapping[str, float]) -> None:
        """Append a row; readers see it immediately."""
        if self.writer is None:
            self.writer = csv.DictWriter(self.file, list(row))
            self.writer.writeheader()
        self.writer.writerow({name: _shortest(value) for name, value in row.items()})
        self.file.flush()

    def close(self) -> None:
        """Close the files and release the folder for other runs."""
        self.file.close()


class IterationFile:
    """`iterations.csv`, a row per Newton iteration."""

    def __init__(self, folder: Path, rows: Sequence[IterationRow]) -> None:
        self.file = (folder / ITERATIONS).open("w", newline="")
        self.writer = csv.writer(self.file)
        self.writer.writerow(IterationRow._fields)
        self.add(rows)

    def add(self, rows: Sequence[IterationRow]) -> None:
        """Append rows; readers see them immediately."""
        self.writer.writerows(rows)
        self.file.flush()

    def close(self) -> None:
        """Close the file."""
        self.file.close()


def _claim(file: Any, folder: Path) -> None:
    """Lock the file; the system lets go of it even when the process is killed."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        file.close()
        raise RequestError(
            "another run is writing to this folder",
            where=f"results folder {folder}",
            hint="wait for it, or name another folder",
        ) from error


def _shortest(value: float) -> float | int:
    """Whole numbers without a decimal point, so that a run that was resumed writes the same text."""
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 2**53 else value


def write_scene(folder: Path, text: str) -> None:
    """Write `scene.toml`, the scene as run. Raises RequestError if the folder cannot be written."""
    try:
        (folder / "scene.toml").write_text(text, encoding="utf-8")
    except OSError as error:
        raise _unwritable(folder, error) from error


def _unwritable(folder: Path, error: OSError) -> RequestError:
    reason = (error.strerror or str(error)).lower()
    return RequestError(f"no results can be written here: {reason}", where=f"results folder {folder}")


def write_contacts(folder: Path, contacts: Mapping[str, ContactHistory]) -> None:
    """Write `contact.csv`: the last stored curve of every contact."""
    with (folder / "contact.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        known = {name: history.last.columns() for name, history in contacts.items() if history.curves}
        names = tuple(
            dict.fromkeys([*ContactCurve.COLUMNS, *(column for columns in known.values() for column in columns)])
        )
        writer.writerow(("contact", *names))
        for name, columns in known.items():
            nothing = [""] * len(columns["s"])
            writer.writerows((name, *row) for row in zip(*(columns.get(n, nothing) for n in names), strict=True))


def write_summary(folder: Path, summary: Mapping[str, Any]) -> None:
    """Write `summary.json`, whole or not at all."""
    path = folder / "summary.json"
    written = path.with_suffix(".json.new")
    written.write_text(json.dumps(summary, indent=1))
    written.replace(path)


def plain(value: object) -> Any:
    """NumPy numbers and arrays as JSON knows them; NaN and inf become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
