"""What a study of cases leaves beside its page: tables as CSV and all of it as JSON."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from contactlab.accuracy.evaluation import Evaluation
from contactlab.accuracy.point import Point
from contactlab.jobs.system import commit, system_facts

COUNTS = ("steps", "iterations", "sweeps", "nodes", "updates")


def point_row(point: Point, side_by_side: int) -> dict[str, Any]:
    """A point as a row; `kernels` is its cost in times of the calibration kernel."""
    return {
        "case": point.case, "contender": point.contender, "slave": point.slave, "level": point.level,
        "status": point.status, "reason": point.reason, "error": point.error,
        "best_error": point.best, "efficiency": point.efficiency, "cpu_s": point.cost,
        "cpu_low_s": min(point.cpu, default=math.nan), "cpu_high_s": max(point.cpu, default=math.nan),
        "kernels": point.cost / point.calibration if point.calibration > 0.0 else math.nan,
        **{name: point.counts.get(name, math.nan) for name in COUNTS},
        "memory_mib": point.memory_mib, "compile_s": point.compile_s, "side_by_side": side_by_side,
    }  # fmt: skip


def write(evaluated: Evaluation, folder: Path) -> None:
    """Write `accuracy.json` and CSV: `accuracy` (points), `costs`, `winners`, `orders`, `solved`, `predictions`."""
    found = evaluated.found
    points = [point_row(point, found.side_by_side) for point in found.points]
    tables: dict[str, list[dict[str, Any]]] = {
        "accuracy": points,
        "costs": [asdict(cost) for cost in evaluated.costs],
        "winners": [asdict(one) | {"group": "; ".join(one.group)} for one in evaluated.winners],
        "orders": [asdict(order) | {"levels": _spaced(order.levels)} for order in evaluated.orders],
        "predictions": [asdict(one) | {"levels": _spaced(one.levels)} for one in evaluated.predictions],
        "solved": [
            {"contender": one.contender, "asked": one.asked, "put": one.put, "number": number, "cpu_s": time}
            for one in evaluated.profiles
            for number, time in enumerate(one.times, start=1)
        ],
    }
    for name, rows in tables.items():
        _write_csv(folder / f"{name}.csv", rows)
    data = {
        "format": 1, "name": found.study.name, "cases": [asdict(each) for each in found.asked],
        "contenders": list(found.contenders), "interrupted": found.interrupted,
        "date": f"{datetime.now(UTC):%Y-%m-%d}", "commit": commit(), "system": system_facts(),
        "points": points, "costs": tables["costs"], "winners": [asdict(one) for one in evaluated.winners],
        "orders": [asdict(order) for order in evaluated.orders],
        "solved": [asdict(one) for one in evaluated.profiles],
        "predictions": [asdict(one) for one in evaluated.predictions],
    }  # fmt: skip
    (folder / "accuracy.json").write_text(json.dumps(finite(data), indent=1, allow_nan=False), encoding="utf-8")


def _write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]) if rows else ["nothing"])
        table.writeheader()
        table.writerows({name: _bare(value) for name, value in row.items()} for row in rows)


def _spaced(levels: Sequence[int]) -> str:
    return " ".join(map(str, levels))


def _bare(value: Any) -> Any:
    """Nothing for a number that there is not, nine figures of others."""
    if isinstance(value, float):
        return f"{value:.9g}" if math.isfinite(value) else ""
    return value


def finite(value: Any) -> Any:
    """The same plain data for JSON, with None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {name: finite(item) for name, item in value.items()}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
