"""Rows that studies keep beside them, as CSV; `contactlab.jobs.rows.write_csv` writes them."""

from __future__ import annotations

import csv
from pathlib import Path

Row = dict[str, str]


def read(path: Path) -> list[Row]:
    """The rows of a file; none where there is none."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
