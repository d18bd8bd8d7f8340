"""`table.csv` and `table.json`: a row per run, failures included."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from contactlab.jobs.rows import finite, write_csv
from contactlab.studies.cost_breakdown import CostBreakdown
from contactlab.studies.measures import mutual_difference, relative_difference
from contactlab.studies.reference import Reference
from contactlab.studies.table import Row, Table


@dataclass(frozen=True)
class Agreement:
    """Two algorithms on runs that differ in nothing else.

    varied    what else they share of what the study varies
    reaction  relative difference of the reactions
    pressure  2 ||p_a - p_b|| / (||p_a|| + ||p_b||)
    """

    first: str
    second: str
    slave: str
    level: int
    reaction: float
    pressure: float
    varied: str = ""


def agreements(rows: Sequence[Row]) -> list[Agreement]:
    """All pairs of algorithms whose runs carried the load to its end, run by run."""
    groups: dict[tuple[str, int, str], list[Row]] = {}
    for row in (row for row in rows if row.complete):
        groups.setdefault((row.slave, row.level, str(row.choices)), []).append(row)
    return [_compare(a, b) for group in groups.values() for a, b in itertools.combinations(group, 2)]


def _compare(a: Row, b: Row) -> Agreement:
    pressure = math.nan
    if a.profile is not None and b.profile is not None:
        pressure = mutual_difference(a.profile, b.profile)
    reaction = relative_difference(a["reaction"], b["reaction"])
    varied = ", ".join(f"{key} = {value}" for key, value in a.choices.items())
    return Agreement(a.algorithm, b.algorithm, a.slave, a.level, reaction, pressure, varied)


def write_table(table: Table, folder: Path) -> None:
    """Write both files into the folder, and `bill.csv` if the cost of effects was measured."""
    write_csv(folder / "table.csv", table.columns(), (row.record() for row in table.rows))
    _write_json(table, folder / "table.json")
    if table.breakdown is not None:
        effects = table.breakdown.effects
        write_csv(folder / "bill.csv", [each.name for each in fields(effects[0])], map(asdict, effects))


def _write_json(table: Table, path: Path) -> None:
    data = {
        "format": 1,
        "study": table.study.as_data(),
        "reference": table.reference.name if table.reference else None,
        "reference_curve": _reference(table.reference),
        "scene": table.scene_text,
        "further": table.further,
        "wall_s": table.wall_s,
        "agreement": agreements(table.rows),
        **({"bill": _breakdown(table.breakdown)} if table.breakdown is not None else {}),
        "rows": [_row(row) for row in table.rows],
    }
    path.write_text(json.dumps(finite(data), indent=1, default=str) + "\n", encoding="utf-8")


def _row(row: Row) -> dict[str, Any]:
    warnings = [warning.as_data() for warning in row.warnings]
    kept = {
        "path": row.path, "share": row.share, "choices": dict(row.choices), "notes": list(row.notes),
        "varied": list(row.varied), "measures": list(row.measures), "system": list(row.system),
    }  # fmt: skip
    return {
        **row.record(), "warnings": warnings, "parts": row.parts, "refines": row.refines, "kept": kept,
    }  # fmt: skip


def _reference(reference: Reference | None) -> dict[str, Any] | None:
    """All of a reference, so that a comparison can be read back wherever it came from."""
    if reference is None:
        return None
    return {
        "name": reference.name, "title": reference.title, "origin": reference.origin, "level": reference.level,
        "window": reference.window, "scalars": reference.scalars, "error_estimate": reference.error_estimate,
        "x": reference.profile.x.tolist(), "pressure": reference.profile.value.tolist(),
        "spread": reference.spread.tolist(),
    }  # fmt: skip


def _breakdown(breakdown: CostBreakdown) -> dict[str, Any]:
    data = asdict(breakdown)
    effects = data.pop("effects")
    return {**data, "prices": effects}
