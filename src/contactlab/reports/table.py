"""The tables of a comparison: every run a row, times by phase, and all numbers of a few runs."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from contactlab.api.drawing.colours import styles
from contactlab.api.drawing.units import Units
from contactlab.api.warning import RunWarning
from contactlab.reports.findings import heading
from contactlab.reports.numbers import heading_unit, percent, quantity, significant
from contactlab.reports.run_details import part_label, why_apart
from contactlab.reports.sheet import Cell, Column, Line, Sheet, numbers
from contactlab.studies import columns
from contactlab.studies.table import Row, Table

USUAL = (
    "peak_force",
    "reaction",
    "peak_pressure",
    "reaction_against_pressure",
    "pressure_error",
    "swap_asymmetry",
    "oscillation",
    "sideways_force",
    "max_penetration",
    "steps",
    "cpu_s",
)

ESSENTIAL = ("pressure_error", "reaction_error", "cpu_s")
"""Error and cost: the last columns to go if there is little room."""

_SHORT = {
    "reaction_against_pressure": "reaction\nvs pressure",
    "pressure_error": "p error\nL2",
    "largest_pressure_error": "largest\np error",
    "swap_asymmetry": "swap\nasym. S",
    "swap_reaction_difference": "swap\nreaction",
    "reaction_error": "reaction\nerror",
    "reaction_mismatch": "sum of\nreactions",
    "oscillation": "oscill.\nO",
    "turning_points": "turning\npoints",
    "mirror_asymmetry": "mirror\nasym.",
    "sideways_force": "sideways\nforce",
    "max_pressure": "max\npressure",
    "peak_force": "peak\nforce",
    "peak_force_time": "time of\npeak force",
    "peak_pressure": "peak\npressure",
    "peak_pressure_time": "time of\npeak pressure",
    "max_penetration": "max\npenetr.",
    "kinetic_share": "kinetic/\ninternal",
    "sweeps": "sweeps\n/step",
}

_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")

_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def usual(table: Table) -> Sequence[str]:
    """Names of the measures that the study requests."""
    return table.study.measures or USUAL


def known(table: Table, names: Sequence[str], rows: Sequence[Row]) -> list[columns.Column]:
    """Measures of these names that any of the rows has."""
    found = {column.name: column for column in table.measures}
    return [found[name] for name in names if any(_value(row, name) == _value(row, name) for row in rows)]


def _value(row: Row, name: str) -> float:
    return row.measures.get(name, math.nan)


def runs_sheet(table: Table, names: Sequence[str], rows: Sequence[Row] | None = None, links: bool = False) -> Sheet:
    """A row per run: what was chosen, how it ended, and the measures of these names that any row has.

    links  to the folders of runs, seen from the folder of the comparison
    """
    rows = table.rows if rows is None else rows
    keys = list(dict.fromkeys(key for row in rows for key in row.choices))
    measures = known(table, names, rows)
    alike = {row.name: n for n, group in enumerate(failed_alike(table), start=1) for row in group}
    colours = styles(row.algorithm for row in table.rows)

    def line(row: Row, following: Row | None) -> Line:
        here = links and table.folder is not None and (table.folder / "runs" / row.name).is_dir()
        link = f"runs/{row.name}/" if here else ""
        mark = (f" {alike[row.name]}".translate(_RAISED) if row.name in alike else "") + (" !" if row.warnings else "")
        cells = [
            Cell(row.algorithm, link=link, swatches=(colours[row.algorithm].colour,)),
            Cell(row.slave),
            *(Cell(str(row.choices.get(key, ""))) for key in keys),
            Cell(str(row.level), row.level),
            Cell(row.status, kind=row.status, mark=mark),
            *(Cell(quantity(_value(row, c.name), c.unit, c.digits), _value(row, c.name)) for c in measures),
        ]
        below = [("", row.reason)] * bool(row.reason) + [(warning.code, warning.text) for warning in row.warnings]
        ends = following is not None and following.refines != row.refines
        return Line(cells, "refines" if row.refines else "", below, ends)

    heads = [*map(Column, ("algorithm", "slave", *keys)), Column("level", meaning="Multiplier of all cell counts.")]
    heads.append(Column("status", keep=True))
    heads += [_column(measure, table) for measure in measures]
    lines = [line(row, following) for row, following in zip(rows, [*rows[1:], None], strict=True)]
    return Sheet(heads, lines, heading(table), "--verbose, table.csv")


def _column(measure: columns.Column, table: Table) -> Column:
    return Column(
        measure.title, unit_of(measure, table), _SHORT.get(measure.name, ""), measure.meaning, number=True, whole=True,
        leaves=2 if measure.name in ESSENTIAL else 1, extra=measure.name not in usual(table),
    )  # fmt: skip


def unit_of(measure: columns.Column, table: Table) -> str:
    """Name of the unit that the values of a measure are shown in."""
    units = Units.of_label(table.scene.get("units"))
    return heading_unit(measure.unit, units[measure.unit] if measure.unit else "")


def table_tex(table: Table) -> str:
    """A `tabular` with a row per run of the study and the usual measures that any of them has."""
    sheet = runs_sheet(table, usual(table), table.main)
    return f"% {table.study.name}; needs \\usepackage{{booktabs}}\n{sheet.tex()}\n"


# --- on a terminal ---


def render(table: Table) -> RenderableType:
    """The table and the notes below it."""
    names = usual(table)
    there = known(table, names, table.rows)
    titles = {column.name: column.title for column in table.measures if column not in there}
    empty = [titles[name] for name in names if name in titles]
    told = f"none of {len(table)} runs finished; see the reasons below the table"
    first = [] if any(row.complete for row in table.rows) else [Text(told, style="bold red")]
    return Group(*first, runs_sheet(table, names), *_notes(table, empty))


def failed_alike(table: Table) -> list[list[Row]]:
    """Runs that did not finish, in groups with equal statuses and reasons up to numbers and advice."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in table.failed:
        groups.setdefault((row.status, _NUMBER.sub("#", row.reason.partition("; try ")[0])), []).append(row)
    return list(groups.values())


def failure(rows: Sequence[Row]) -> str:
    """Sentence about runs that failed alike, with the reason of the first."""
    first = rows[0]
    if len(rows) == 1:
        return f"{_who(first)}, {first.status}: {first.reason}"
    algorithms = ", ".join(dict.fromkeys(row.algorithm for row in rows))
    return f"{len(rows)} runs alike ({algorithms}), {first.status}; {_who(first)}: {first.reason}"


def _notes(table: Table, empty: Sequence[str]) -> list[Text]:
    notes = [
        Text.assemble((f"{number} ".translate(_RAISED), "bold"), failure(rows))
        for number, rows in enumerate(failed_alike(table), start=1)
    ]
    # a line per kind of warning: the worst of it, and how many more runs have it
    found: dict[str, list[tuple[Row, RunWarning]]] = {}
    for row in table.rows:
        for code, warning in {warning.code: warning for warning in row.warnings}.items():
            found.setdefault(code, []).append((row, warning))
    notes += [_warning(code, seen) for code, seen in found.items()]
    notes.append(_reference_note(table))
    return [*notes, Text("no run has: " + ", ".join(empty), style="dim")] if empty else notes


def _warning(code: str, seen: Sequence[tuple[Row, RunWarning]]) -> Text:
    row, worst = max(seen, key=lambda pair: pair[1].excess)
    others = f" (worst of {len(seen)} runs)" if len(seen) > 1 else ""
    return Text.assemble((f"! {code}: ", "bold yellow"), f"{_who(row)}{others}: {worst.text}")


def _who(row: Row) -> str:
    return f"{row.algorithm}, slave {row.slave}, level {row.level}"


def _reference_note(table: Table) -> Text:
    reference = table.reference
    if reference is None:
        why = next((note for row in table.rows for note in row.notes), "no run has a pressure")
        return Text(f"pressure error not computed: {why} (--reference finest makes one)", style="dim")
    known = percent(reference.pressure_uncertainty)
    return Text(f"reference: {reference.title}; uncertainty of its pressure {known} %", style="dim")


def every_number(table: Table, width: int) -> RenderableType:
    """A row per measure and a column per run, as many columns as fit."""
    return Group(*_beside(table, width), *_remarks(table))


def _beside(table: Table, width: int) -> Iterator[Sheet]:
    rows = list(table.rows)
    while rows:
        count = len(rows)
        while count > 1 and (sheet := _transposed(table, rows[:count])).width(range(count + 2)) > width:
            count -= 1
        yield sheet
        rows = rows[count:]


def _transposed(table: Table, rows: Sequence[Row]) -> Sheet:
    def name(row: Row) -> str:
        choices = [f"{key.rpartition('.')[2]} {value}" for key, value in row.choices.items()]
        return "\n".join([row.algorithm, f"slave {row.slave}", *choices, f"level {row.level}"])

    lines = [["status", *(row.status for row in rows), ""]]
    for c in known(table, [column.name for column in table.measures], rows):
        lines.append([c.title, *(quantity(_value(row, c.name), c.unit, c.digits) for row in rows), unit_of(c, table)])
    return Sheet([Column("", keep=True), *(Column(name(row), number=True, keep=True) for row in rows), ""], lines)


def _remarks(table: Table) -> Iterator[Text]:
    """Reasons and warnings of each run."""
    for row in table.rows:
        lines = [f"{row.status}: {row.reason}"] if row.reason else []
        lines += [f"{warning.code}: {warning.text}" for warning in row.warnings]
        if lines:
            yield Text.assemble((row.name, "bold"), "\n", "\n".join(lines))


# --- times by phase ---


def times_sheet(table: Table) -> Sheet:
    """A row for every phase and part of every run that left a summary."""
    lines = (line for row in table.rows for line in _times(row.name, _cost(table.folder, row.name)))
    return Sheet(["run", "phase", "part", *numbers("share, %", "seconds")], lines)


def _cost(folder: Path | None, name: str) -> Mapping[str, Any]:
    path = Path() if folder is None else folder / "runs" / name / "summary.json"
    if not path.is_file():
        return {}
    cost: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8")).get("cost", {})
    return cost


def _times(name: str, cost: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
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
