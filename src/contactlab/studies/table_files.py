"""`table.csv` and `table.json`: a row per run, failures included."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from contactlab.studies.agreement import agreements
from contactlab.studies.cost_breakdown import CostBreakdown
from contactlab.studies.reference import Reference
from contactlab.studies.table import Row, Table


def write_table(table: Table, folder: Path) -> None:
    """Write both files into the folder, and `bill.csv` where the cost of effects was measured."""
    _write_csv(table, folder / "table.csv")
    _write_json(table, folder / "table.json")
    if table.breakdown is not None:
        _write_breakdown(table.breakdown, folder / "bill.csv")


def _write_breakdown(breakdown: CostBreakdown, path: Path) -> None:
    """Write `bill.csv`: a row for each effect."""
    rows = [asdict(cost) for cost in breakdown.effects]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows({name: _cell(value) for name, value in row.items()} for row in rows)


def _write_csv(table: Table, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, table.columns(), restval="")
        writer.writeheader()
        writer.writerows({name: _cell(value) for name, value in row.record().items()} for row in table.rows)


def _write_json(table: Table, path: Path) -> None:
    data = {
        "format": 1,
        "study": table.study.as_data(),
        "reference": table.reference.name if table.reference else None,
        "reference_curve": _reference(table.reference),
        "scene": table.scene_text,
        "further": [asdict(column) for column in table.further],
        "wall_s": _number(table.wall_s),
        "agreement": [_plain(asdict(item)) for item in agreements(table.rows)],
        **({"bill": _breakdown(table.breakdown)} if table.breakdown is not None else {}),
        "rows": [_row(row) for row in table.rows],
    }
    path.write_text(json.dumps(data, indent=1, default=str) + "\n", encoding="utf-8")


def _row(row: Row) -> dict[str, Any]:
    warnings = [_plain(warning.as_data()) for warning in row.warnings]
    kept = {
        "path": row.path, "choices": dict(row.choices), "notes": list(row.notes), "varied": list(row.varied),
        "measures": list(row.measures), "system": list(row.system),
    }  # fmt: skip
    return {
        **_plain(row.record()), "warnings": warnings, "parts": _plain(row.parts), "refines": row.refines, "kept": kept,
    }  # fmt: skip


def _reference(reference: Reference | None) -> dict[str, Any] | None:
    """All of a reference, so that a comparison can be read back wherever it came from."""
    if reference is None:
        return None
    scalars = {name: _plain(scalar) for name, scalar in reference.scalars.items()}
    return {
        "name": reference.name, "title": reference.title, "origin": reference.origin, "level": reference.level,
        "window": reference.window, "scalars": scalars, "error_estimate": _plain(reference.error_estimate),
        "x": reference.profile.x.tolist(), "pressure": reference.profile.value.tolist(),
        "spread": reference.spread.tolist(),
    }  # fmt: skip


def _breakdown(breakdown: CostBreakdown) -> dict[str, Any]:
    data = asdict(breakdown)
    effects = data.pop("effects")
    return {**_plain(data), "prices": [_plain(cost) for cost in effects]}


def _cell(value: object) -> Any:
    """As written in a CSV file: nothing for a number that is missing."""
    return "" if isinstance(value, float) and math.isnan(value) else value


def _number(value: object) -> Any:
    """As written in JSON, which knows no nan and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _number(value) for name, value in data.items()}
