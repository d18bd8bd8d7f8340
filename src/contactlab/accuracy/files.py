"""Files of a study of cases in addition to its page: tables as CSV and everything as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from contactlab.accuracy.evaluation import Evaluation
from contactlab.accuracy.point import Point
from contactlab.jobs.rows import finite, write_csv
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
    """Write `accuracy.json` and CSV: `accuracy` (points), `costs`, `winners`, `orders`, `solved`."""
    found = evaluated.found
    points = [point_row(point, found.side_by_side) for point in found.points]
    tables: dict[str, list[dict[str, Any]]] = {
        "accuracy": points,
        "costs": [asdict(cost) for cost in evaluated.costs],
        "winners": [asdict(one) | {"group": "; ".join(one.group)} for one in evaluated.winners],
        "orders": [asdict(order) | {"levels": " ".join(map(str, order.levels))} for order in evaluated.orders],
        "solved": [
            {"contender": one.contender, "asked": one.asked, "put": one.put, "number": number, "cpu_s": time}
            for one in evaluated.profiles
            for number, time in enumerate(one.times, start=1)
        ],
    }
    for name, rows in tables.items():
        write_csv(folder / f"{name}.csv", list(rows[0]) if rows else ["nothing"], rows, digits=9)
    data = {
        "format": 1, "name": found.study.name, "cases": found.asked,
        "contenders": list(found.contenders), "interrupted": found.interrupted,
        "date": f"{datetime.now(UTC):%Y-%m-%d}", "commit": commit(), "system": system_facts(),
        "points": points, "costs": tables["costs"], "winners": evaluated.winners,
        "orders": evaluated.orders,
        "solved": evaluated.profiles,
    }  # fmt: skip
    (folder / "accuracy.json").write_text(json.dumps(finite(data), indent=1, allow_nan=False), encoding="utf-8")
