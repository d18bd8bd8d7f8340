"""A comparison read back from its folder."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from contactlab.api.frame import ContactCurve
from contactlab.api.warning import RunWarning
from contactlab.arguments import NAME, arguments
from contactlab.errors import RequestError, one_line
from contactlab.jobs.rows import number, read_csv
from contactlab.results.load import load_results
from contactlab.scene.toml_text import location, parse_toml
from contactlab.studies.columns import BY_NAME, Column
from contactlab.studies.cost_breakdown import CostBreakdown, EffectCost
from contactlab.studies.profile import Profile
from contactlab.studies.recordings import RUNS
from contactlab.studies.reference import Reference
from contactlab.studies.shape import shapes_of
from contactlab.studies.study import study_from
from contactlab.studies.table import Row, Table

T = TypeVar("T")


@arguments(folder=NAME)
def load_table(folder: str | Path) -> Table:
    """The table of the comparison in `folder`, equal to what `compare` gave back.

    Curves and bodies come from the run folders that were kept. Raises RequestError if there is no comparison.
    """
    folder = Path(folder)
    path = folder / "table.json"
    if not path.is_file():
        raise RequestError(
            "the folder holds no comparison", where=str(folder), got=str(folder), allowed="a folder with table.json",
            hint="load_results reads a single run" if (folder / "summary.json").is_file() else "",
        )  # fmt: skip
    try:
        return _table(json.loads(path.read_text(encoding="utf-8")), folder)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RequestError(f"the comparison cannot be read: {one_line(error)}", where=str(path)) from error


def _table(data: Mapping[str, Any], folder: Path) -> Table:
    study = study_from(
        data["study"], location(str(folder / "table.json"), {}), measures=[*BY_NAME, *data["study"].get("measures", ())]
    )
    rows = [_row(row, study.contact, folder / RUNS / row["name"]) for row in data["rows"]]
    text = str(data.get("scene", ""))
    further = [Column(**column) for column in data.get("further", ())]
    return Table(
        rows, study, _reference(data.get("reference_curve")), parse_toml(text, "scene.toml") if text else {}, text,
        number(data.get("wall_s")), folder, _breakdown(data.get("bill")), False, further,
    )  # fmt: skip


def _row(data: Mapping[str, Any], contact: str, folder: Path) -> Row:
    results, kept = _or_nothing(lambda: load_results(folder)), data["kept"]
    rows = read_csv(folder / "history.csv")
    return Row(
        name=data["name"],
        algorithm=data["algorithm"],
        slave=data["slave"],
        level=data["level"],
        varied={key: data[key] for key in kept["varied"]},
        status=data["status"],
        reason=data["reason"],
        measures={name: number(data[name]) for name in kept["measures"]},
        notes=kept["notes"],
        warnings=[RunWarning.from_data(warning) for warning in data["warnings"]],
        system={key: data[key] for key in kept["system"]},
        parts=data["parts"],
        reference=data["reference"],
        choices=kept["choices"],
        curve=_curve(folder, contact),
        shapes=shapes_of(results) if results is not None and results.restartable else {},
        refines=data["refines"],
        history={name: np.array([number(row[name] or None) for row in rows]) for name in rows[0]} if rows else {},
        path=kept["path"],
        share=kept.get("share", 1.0),
    )


def _or_nothing(read: Callable[[], T]) -> T | None:
    """Return the result of `read`; None if the files were not kept or are damaged."""
    try:
        return read()
    except (RequestError, OSError, KeyError, ValueError):
        return None


def _curve(folder: Path, contact: str) -> ContactCurve | None:
    rows = [row for row in read_csv(folder / "contact.csv") if row["contact"] == contact]
    if not rows:
        return None
    # other contacts have memories of their own
    memory = [name for name, value in rows[0].items() if name.startswith("memory.") and value]
    values = [np.array([float(row[name]) for row in rows]) for name in (*ContactCurve.COLUMNS, *memory)]
    return ContactCurve.of_table(values, [name.partition(".")[2] for name in memory])


def _reference(data: Mapping[str, Any] | None) -> Reference | None:
    if data is None:
        return None
    profile = Profile(np.array(data["x"], float), np.array(data["pressure"], float))
    rest = {name: data[name] for name in ("name", "title", "origin", "scalars", "error_estimate", "level")}
    window = tuple(data["window"]) if data["window"] else None
    return Reference(profile=profile, spread=np.array(data["spread"], float), window=window, **rest)


def _breakdown(data: Mapping[str, Any] | None) -> CostBreakdown | None:
    if data is None:
        return None
    whole: dict[str, Any] = {
        name: math.nan if value is None else value for name, value in data.items() if name != "prices"
    }
    prices: list[dict[str, Any]] = [
        {k: math.nan if v is None else v for k, v in cost.items()} for cost in data["prices"]
    ]
    return CostBreakdown(**whole, effects=[EffectCost(**cost) for cost in prices])
