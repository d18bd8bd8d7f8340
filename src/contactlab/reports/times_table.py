"""Where the time of every run of a comparison went, part by part."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table as RichTable
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.reports.html import plain_table, section
from contactlab.reports.numbers import heading_unit, percent, quantity, significant
from contactlab.reports.run_details import part_label, why_apart
from contactlab.reports.terminal import Terminal
from contactlab.studies.table import Row, Table

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


def every_number(table: Table, width: int) -> RenderableType:
    """A row per measure and a column per run, as many runs beside each other as fit."""
    return Group(*(_draw(table, rows) for rows in _beside(table, width)), *_remarks(table))


def _beside(table: Table, width: int) -> Iterator[Sequence[Row]]:
    rows = list(table.rows)
    while rows:
        count = len(rows)
        while count > 1 and Terminal(width=1000).measure(_draw(table, rows[:count])).maximum > width:
            count -= 1
        yield rows[:count]
        rows = rows[count:]


def _draw(table: Table, rows: Sequence[Row]) -> RichTable:
    units = Units.of_label(table.scene.get("units"))
    drawn = RichTable(box=box.SIMPLE_HEAD, pad_edge=False)
    drawn.add_column("")
    for row in rows:
        drawn.add_column(Text("\n".join([row.algorithm, f"slave {row.slave}", *_choices(row), f"level {row.level}"])),
                         justify="right")  # fmt: skip
    drawn.add_column("", style="dim")
    drawn.add_row("status", *(row.status for row in rows))
    for column in table.measures:
        values = [row.measures.get(column.name, math.nan) for row in rows]
        if any(value == value for value in values):
            cells = [quantity(value, column.unit, column.digits) for value in values]
            drawn.add_row(Text(column.title), *map(Text, cells), Text(heading_unit(column.unit, units[column.unit])))
    return drawn


def _choices(row: Row) -> list[str]:
    return [f"{key.rpartition('.')[2]} {value}" for key, value in row.choices.items()]


def _remarks(table: Table) -> Iterator[Text]:
    """Reasons and warnings of each run."""
    for row in table.rows:
        lines = [f"{row.status}: {row.reason}"] if row.reason else []
        lines += [f"{warning.code}: {warning.text}" for warning in row.warnings]
        if lines:
            yield Text.assemble((row.name, "bold"), "\n", "\n".join(lines))


def where_the_time_went(table: Table) -> RenderableType:
    """A row for every phase and part of every run."""
    drawn = RichTable(box=box.SIMPLE_HEAD, pad_edge=False)
    for number, head in enumerate(HEADS):
        drawn.add_column(head, justify="left" if number < 3 else "right")
    for cells in times_rows(table):
        drawn.add_row(*map(Text, cells), end_section=False)
    return drawn
