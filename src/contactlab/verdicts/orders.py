"""Orders of convergence in a matrix of several levels: errors of one configuration against its mesh size."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.accuracy.orders import slope
from contactlab.jobs.archive import CHOICES
from contactlab.jobs.rows import write_csv
from contactlab.verdicts.run import Matrix

ROUND_OFF = 1e-9
"""Errors below it do not come from the mesh."""
COLUMNS = (*CHOICES, "measure", "levels", "order", "interval", "theory")


def orders(matrix: Matrix) -> list[dict[str, Any]]:
    """q of |error| ~ h^q by least squares over the levels, `interval` the half-width of its 95 % interval (Student).

    One row for each configuration and measure of role "error" that has at least two levels; the interval is None for
    two, the theory None if the case names none.
    """
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    for cell, result in matrix.cells:
        level = cell.setup.level
        head = cell.choices | {"variant": cell.choices["variant"].removesuffix(f"level={level}").removesuffix(", ")}
        for measure in result.measures:
            error = measure["value"]
            counted = measure.get("unit") == "h"  # in cells, which grow with the mesh
            if measure["role"] != "error" or counted or not math.isfinite(error) or abs(error) < ROUND_OFF:
                continue
            key = (*head.values(), measure["measure"])
            line = found.setdefault(
                key, head | {"measure": measure["measure"], "theory": measure.get("order"), "at": {}}
            )
            line["at"][level] = abs(error)
    return [_row(line) for line in found.values() if len(line["at"]) > 1]


def _row(line: dict[str, Any]) -> dict[str, Any]:
    levels = sorted(line["at"])
    order, half = slope(np.log(levels), np.log([line["at"][level] for level in levels]))
    return {name: line[name] for name in (*CHOICES, "measure", "theory")} | {
        "levels": " ".join(map(str, levels)), "order": -order, "interval": None if math.isnan(half) else half,
    }  # fmt: skip


def write_orders(matrix: Matrix, folder: Path) -> None:
    """Write orders.csv if there are any."""
    found = orders(matrix)
    if found:
        write_csv(folder / "orders.csv", COLUMNS, found)
