"""Where the time of every run of a comparison went, part by part."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from contactlab.reports.html import plain_table, section
from contactlab.reports.numbers import percent, significant
from contactlab.reports.run_details import part_label, why_apart
from contactlab.studies.table import Table

_TEXT = (
    "<p>Wall time of the steps, kernels compiled or loaded in it too, and the share of each phase and of the parts in "
    "it. Shares of laws and elements were measured on the state at the end; implicit runs solve contact together with "
    "the bodies.</p>"
)


HEADS = ("run", "phase", "part", "share, %", "seconds")


def times_section(table: Table) -> str:
    """The table, folded away; empty if no run left a summary."""
    rows = times_rows(table)
    if not rows:
        return ""
    folded = (
        f"<details><summary>{len(table)} runs, phase by phase</summary>{plain_table(HEADS, rows, texts=3)}</details>"
    )
    return section("Where the time went", _TEXT + folded)


def times_rows(table: Table) -> list[tuple[str, ...]]:
    """A row for every phase and part of every run that left a summary."""
    return [line for row in table.rows for line in _rows(row.name, _cost(table.folder, row.name))]


def _cost(folder: Path | None, name: str) -> Mapping[str, Any]:
    path = Path() if folder is None else folder / "runs" / name / "summary.json"
    if not path.is_file():
        return {}
    cost: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8")).get("cost", {})
    return cost


def _rows(name: str, cost: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    phases = cost.get("phases", {})
    whole = sum(phases.values())
    if not whole > 0.0:
        return
    apart = why_apart(float(cost.get("run_cpu_s", 0.0)), float(cost.get("run_wall_s", 0.0)))
    yield name, "all steps" + (f" ({apart})" if apart else ""), "", "100", significant(whole, 3)
    for phase, seconds in phases.items():
        yield "", phase, "", percent(seconds / whole), significant(seconds, 3)
        for what, parts in cost.get("parts", {}).get(phase, {}).items():
            for part, time in parts.items():
                yield "", "", what + part_label(part), percent(time / whole), significant(time, 3)
