"""Rows as CSV files, and plain data as JSON has them."""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

Row = dict[str, str]


def read_csv(path: Path) -> list[Row]:
    """Rows of a file; none if there is no file."""
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_csv(path: Path, columns: Sequence[str], rows: Iterable[Mapping[str, Any]], digits: int | None = None) -> None:
    """Write these columns of the rows, numbers with so many `digits`; nothing for a number that is not finite."""

    def cell(value: Any) -> Any:
        if not isinstance(value, float):
            return value
        return "" if not math.isfinite(value) else value if digits is None else f"{value:.{digits}g}"

    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, columns, restval="")
        table.writeheader()
        table.writerows({name: cell(row[name]) for name in columns if name in row} for row in rows)


def finite(value: Any) -> Any:
    """Records, tables and lists as plain ones, with None for numbers that are not finite."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: finite(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if hasattr(value, "_asdict"):
        return finite(value._asdict())
    if isinstance(value, Mapping):
        return {str(name): finite(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def number(value: Any) -> float:
    """A number of a file in JSON; null is NaN."""
    return math.nan if value is None else float(value)
