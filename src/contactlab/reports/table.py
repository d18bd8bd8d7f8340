"""The table of a comparison on a terminal: every run a row, what failed and why below."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.console import Console, Group, RenderableType
from rich.table import Table as RichTable
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.api.warning import RunWarning
from contactlab.reports.findings import heading
from contactlab.reports.numbers import heading_unit, percent, quantity
from contactlab.reports.terminal import Terminal
from contactlab.studies.columns import Column
from contactlab.studies.table import Row, Table

WIDTH = 140
"""Columns of text that the usual table needs."""

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
"""Error and cost: the last to go where there is little room."""

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

_COLOURS = {"finished": "green", "not-converged": "yellow"}


@dataclass(frozen=True)
class _Shown:
    """A column as it is drawn: heading, a cell for each row, and what to call it where it is left out."""

    heading: Text
    cells: Sequence[Text]
    title: str
    unit: str = ""
    number: bool = True
    essential: bool = False

    @property
    def constant(self) -> bool:
        """Whether every row has the same value in a column."""
        return len(self.cells) > 1 and len({cell.plain for cell in self.cells}) == 1


def print_table(table: Table, console: Console | None = None) -> None:
    """Print the table; where nobody says how wide it may be, as wide as it needs to be."""
    console = console or Terminal()
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console = Terminal(file=console.file, width=max(WIDTH, console.width))
    console.print(render(table, console.width))


def render(table: Table, width: int = WIDTH) -> RenderableType:
    """The table and the notes below it. What does not fit into `width` stays in `table.csv`.

    First those columns go that say the same in every row, which then stands below; then numbers, error and cost last.
    """
    columns, empty = _columns(table)
    same: list[_Shown] = []
    left_out: list[_Shown] = []
    for column in _least_important_first(columns):
        if Terminal(width=1000).measure(_draw(table, columns)).maximum <= width:
            break
        columns.remove(column)
        if column.constant:
            same.append(column)
        else:
            left_out.insert(0, column)
    return Group(*_nothing_finished(table), _draw(table, columns), *_notes(table, same, left_out, empty))


def _least_important_first(columns: Sequence[_Shown]) -> list[_Shown]:
    constant = [c for c in columns if c.constant]
    rest = [c for c in columns if not c.constant and c.number]
    usual = [c for c in reversed(rest) if not c.essential]
    return [*constant, *usual, *(c for c in reversed(rest) if c.essential)]


def _nothing_finished(table: Table) -> list[Text]:
    """The first thing to know if it is so: there is nothing to compare."""
    if any(row.complete for row in table.rows):
        return []
    return [Text(f"not one of {len(table)} runs finished; the reasons are below the table", style="bold red")]


def failed_alike(table: Table) -> list[list[Row]]:
    """Runs that did not finish, in groups whose statuses and reasons differ in numbers and advice alone."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in table.failed:
        groups.setdefault((row.status, _NUMBER.sub("#", row.reason.partition("; try ")[0])), []).append(row)
    return list(groups.values())


def failure(rows: Sequence[Row]) -> str:
    """One sentence about runs that failed alike, with the reason of the first."""
    first = rows[0]
    if len(rows) == 1:
        return f"{_who(first)}, {first.status}: {first.reason}"
    algorithms = ", ".join(dict.fromkeys(row.algorithm for row in rows))
    return f"{len(rows)} runs alike ({algorithms}), {first.status}; {_who(first)}: {first.reason}"


def _columns(table: Table) -> tuple[list[_Shown], list[str]]:
    """All columns in the order of the table, and titles of measures that no run has."""
    units = Units.of_label(table.scene.get("units"))
    keys = list(dict.fromkeys(key for row in table.rows for key in row.choices))
    numbers = {row.name: n for n, rows in enumerate(failed_alike(table), start=1) for row in rows}
    words = {"algorithm": [row.algorithm for row in table.rows], "slave": [row.slave for row in table.rows]}
    words |= {key: [str(row.choices.get(key, "")) for row in table.rows] for key in keys}
    words["level"] = [str(row.level) for row in table.rows]
    shown = [_Shown(Text(name), [Text(cell) for cell in cells], name, number=False) for name, cells in words.items()]
    status = [_status(row, numbers.get(row.name)) for row in table.rows]
    shown.append(_Shown(Text("status"), status, "status", number=False))
    known = {column.name: column for column in table.measures}
    measures = [known[name] for name in table.study.measures or USUAL]
    missing = {c.name for c in measures if all(row[c.name] != row[c.name] for row in table.rows)}
    for column in (c for c in measures if c.name not in missing):
        cells = [Text(quantity(row[column.name], column.unit, column.digits)) for row in table.rows]
        unit = heading_unit(column.unit, units[column.unit] if column.unit else "")
        shown.append(_Shown(_heading(column, unit), cells, column.title, unit, essential=column.name in ESSENTIAL))
    return shown, [column.title for column in measures if column.name in missing]


def _draw(table: Table, columns: Sequence[_Shown]) -> RichTable:
    drawn = RichTable(
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
        collapse_padding=True,
        pad_edge=False,
        title=Text(heading(table)),
        title_justify="left",
    )
    for column in columns:
        drawn.add_column(column.heading, no_wrap=True, justify="right" if column.number else "left")
    for number, (row, following) in enumerate(zip(table.rows, [*table.rows[1:], None], strict=True)):
        ends = following is not None and following.refines != row.refines
        drawn.add_row(*(column.cells[number] for column in columns), end_section=ends)
    return drawn


def _heading(column: Column, unit: str) -> Text:
    text = Text(_SHORT.get(column.name, column.title))
    return text.append(f"\n{unit}", style="dim") if unit else text


def _status(row: Row, number: int | None) -> Text:
    mark = f" {number}".translate(_RAISED) if number is not None else ""
    status = Text(row.status + mark, style=_COLOURS.get(row.status, "red"))
    return status.append(" !", style="bold yellow") if row.warnings else status


def _notes(table: Table, same: Sequence[_Shown], left_out: Sequence[_Shown], empty: Sequence[str]) -> list[Text]:
    constants = ", ".join(f"{c.title} {c.cells[0].plain} {c.unit}".strip() for c in same)
    notes = [Text(f"in every row: {constants}")] if same else []
    for number, rows in enumerate(failed_alike(table), start=1):
        notes.append(Text.assemble((f"{number} ".translate(_RAISED), "bold"), failure(rows)))
    notes += _warnings(table)
    notes.append(_reference_note(table))
    if empty:
        notes.append(Text("no run has: " + ", ".join(empty), style="dim"))
    if left_out:
        titles = ", ".join(column.title for column in left_out)
        notes.append(Text(f"not shown for lack of width: {titles} (--verbose, table.csv)", style="dim"))
    return notes


def _warnings(table: Table) -> list[Text]:
    """A line per kind of warning: the worst of it, and how many more runs have it."""
    found: dict[str, list[tuple[Row, RunWarning]]] = {}
    for row in table.rows:
        for code, warning in {warning.code: warning for warning in row.warnings}.items():
            found.setdefault(code, []).append((row, warning))
    return [_warning(code, seen) for code, seen in found.items()]


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
