"""Files of a matrix: matrix.csv, one row per measure; matrix.json; parquet if pyarrow is installed."""

from __future__ import annotations

import csv
import importlib.util
import json
import math
from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from contactlab.cases.verdict import WORST
from contactlab.errors import RequestError
from contactlab.jobs.archive import CHOICES, FILE, Archive
from contactlab.jobs.rows import finite, write_csv
from contactlab.outside_files import text_outside
from contactlab.verdicts.orders import orders, write_orders
from contactlab.verdicts.run import Matrix

COLUMNS = (
    *CHOICES, "verdict", "measure", "value", "least", "most", "unit", "status", "reason", "cpu_s", "run"
)  # fmt: skip
NO_MEASURE = {"measure": "", "value": math.nan, "least": -math.inf, "most": math.inf, "unit": ""}


def rows(matrix: Matrix) -> Iterator[dict[str, Any]]:
    """Yield a row per measure, with its own verdict; a cell without measures is one row. Silent cells come first."""
    for cell, result in matrix.worst_first:
        ends = {
            "status": result.status,
            "reason": result.reason,
            "cpu_s": round(result.cpu_s, 3),
            "run": " ".join(result.runs),
        }
        empty = {**NO_MEASURE, "verdict": result.verdict}
        for measure in result.measures or [empty]:
            own = {name: measure[name] for name in ("verdict", "measure", "value", "least", "most", "unit")}
            yield {**cell.choices, **own, **ends}
        if result.measures and result.verdict not in {measure["verdict"] for measure in result.measures}:
            yield {**cell.choices, **empty, **ends}


def write(matrix: Matrix, folder: Path) -> None:
    """Write all files of a matrix but its page."""
    found = list(rows(matrix))
    write_csv(folder / "matrix.csv", COLUMNS, found)
    text = json.dumps({"format": 1, "cells": plain_cells(matrix)}, indent=1, allow_nan=False)
    (folder / "matrix.json").write_text(text, encoding="utf-8")
    if importlib.util.find_spec("pyarrow") is not None:
        import pyarrow as pa
        from pyarrow import parquet

        parquet.write_table(pa.Table.from_pylist(found), folder / "matrix.parquet")


def plain_cells(matrix: Matrix) -> list[Any]:
    """Choices and findings of every cell as JSON has them, silent ones first."""
    return [finite({**cell.choices, **result.as_data()}) for cell, result in matrix.worst_first]


Key = tuple[str, ...]


def verdicts(path: Path) -> dict[Key, str]:
    """The verdict of each cell in a matrix.csv: the worst of its rows. Raises RequestError for other files."""
    path = path / "matrix.csv" if path.is_dir() else path
    try:
        found: dict[Key, str] = {}
        for row in csv.DictReader(text_outside(path, str(path), "a matrix.csv").splitlines(keepends=True)):
            key = tuple(row[name] for name in CHOICES)
            found[key] = min((found.get(key, row["verdict"]), row["verdict"]), key=_rank)
        return found
    except (OSError, KeyError, ValueError) as error:
        raise RequestError(
            "no matrix can be read here", where=str(path), got=str(error), allowed="a matrix.csv"
        ) from error


def _rank(verdict: str) -> int:
    return [str(v) for v in WORST].index(verdict)


def against(matrix: Matrix, before: Mapping[Key, str]) -> dict[str, list[tuple[Key, str, str]]]:
    """Cells that are better, worse, new or gone against an earlier matrix, with both verdicts."""
    now = {tuple(cell.choices.values()): result.verdict for cell, result in matrix.cells}
    changes: dict[str, list[tuple[Key, str, str]]] = {"better": [], "worse": [], "new": [], "gone": []}
    for key, verdict in now.items():
        old = before.get(key)
        if old is None:
            changes["new"].append((key, "", verdict))
        elif old != verdict:
            changes["better" if _rank(verdict) > _rank(old) else "worse"].append((key, old, verdict))
    changes["gone"] = [(key, verdict, "") for key, verdict in before.items() if key not in now]
    return changes


COLOURS = {
    "met": "#1a7f4b", "missed": "#c77700", "failed": "#b42318", "silent": "#7a0bc0", "not-judged": "#5b7083",
    "ill-posed": "#2f6f9f", "not-applicable": "#c3c9d0",
}  # fmt: skip

MEANINGS = {
    "silent": "finished with a wrong result, and no warning reported it",
    "failed": "did not finish",
    "missed": "a measure is outside its limits, or a warning reported the error",
    "not-judged": "stopped: more steps and iterations than the case allows",
    "ill-posed": "the problem has no solution, and the run reported or showed that",
    "met": "all measures are within their limits",
    "not-applicable": "not run",
}


def write_page(matrix: Matrix, folder: Path) -> None:
    """Write the page of a matrix as one self-contained HTML file."""
    numbered = zip(plain_cells(matrix), matrix.worst_first, strict=True)
    cells = [{**cell, "number": result.number} for cell, (_, result) in numbered]
    data = json.dumps(
        {"cells": cells, "colours": COLOURS, "meanings": MEANINGS, "order": WORST, "orders": orders(matrix)},
        allow_nan=False,
    )
    place = files("contactlab") / "data" / "report"
    style = (place / "page.css").read_text(encoding="utf-8")
    page = (place / "matrix.html").read_text(encoding="utf-8")
    # "</" would end the script in which the data stand
    text = page.replace("/* style */", style).replace("/* data */", data.replace("</", "<\\/"))
    (folder / "matrix.html").write_text(text, encoding="utf-8")


def write_folder(found: Matrix, folder: Path) -> None:
    """Write tables, orders of convergence, page, and the scene of every run, where the page leads to."""
    write(found, folder)
    write_orders(found, folder)
    (folder / "scenes").mkdir(exist_ok=True)
    with Archive(folder / FILE, write=False) as archive:
        for run in archive.runs():
            (folder / "scenes" / f"{run['key']}.toml").write_text(run["scene"], encoding="utf-8")
    write_page(found, folder)
