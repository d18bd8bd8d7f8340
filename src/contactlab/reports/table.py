"""The table of a comparison on a terminal: every run a row, what failed and why below."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console, Group, RenderableType
from rich.table import Table as RichTable
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.api.warning import RunWarning
from contactlab.reports.numbers import heading_unit, percent, quantity
from contactlab.studies.columns import BY_NAME, Column
from contactlab.studies.table import Row, Table

WIDTH = 140
"""Columns of text that the usual table needs."""

USUAL = (
    "reaction",
    "reaction_against_pressure",
    "pressure_error",
    "swap_asymmetry",
    "oscillation",
    "sideways_force",
    "max_penetration",
    "steps",
    "sweeps",
    "cpu_s",
)

_SHORT = {
    "reaction_against_pressure": "reaction\nvs ∫p",
    "pressure_error": "p error\nL2",
    "largest_pressure_error": "largest\np error",
    "swap_asymmetry": "swap\nasym. S",
    "swap_reaction_difference": "swap\nreaction",
    "reaction_error": "reaction\nerror",
    "reaction_mismatch": "sum of\nreactions",
    "oscillation": "oscill.\nO",
    "turning_points": "turning\npoints",
    "mirror_asymmetry": "mirror\nasym.",
    "sideways_force": "lateral\nforce",
    "max_pressure": "max\npressure",
    "max_penetration": "max\npenetr.",
    "kinetic_share": "kinetic/\ninternal",
    "sweeps": "sweeps\n/step",
}

_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")

_COLOURS = {"finished": "green", "not-converged": "yellow"}


def print_table(table: Table, console: Console | None = None) -> None:
    """Print the table; where there is no terminal, as wide as it needs to be."""
    console = console or Console()
    if not console.is_terminal:
        console = Console(file=console.file, width=max(WIDTH, console.width))
    console.print(render(table, console.width))


def render(table: Table, width: int = WIDTH) -> RenderableType:
    """The table and the notes below it. Columns that do not fit into `width` stay in `table.csv`."""
    columns = [BY_NAME[name] for name in table.study.measures or USUAL]
    keys = list(dict.fromkeys(key for row in table.rows for key in row.choices))
    for shown in range(len(columns), 0, -1):
        drawn = _draw(table, columns[:shown], keys)
        if Console(width=1000).measure(drawn).maximum <= width:
            break
    return Group(*_nothing_finished(table), drawn, *_notes(table, [c.title for c in columns[shown:]]))


def _nothing_finished(table: Table) -> list[Text]:
    """The first thing to know where it is so: there is nothing to compare."""
    if any(row.complete for row in table.rows):
        return []
    kinds = ", ".join(f"{row.status}: {row.reason}" for row in {row.reason: row for row in table.rows}.values())
    return [Text(f"not one of {len(table)} runs came to its end; {kinds}", style="bold red")]


def _draw(table: Table, columns: Sequence[Column], keys: Sequence[str]) -> RichTable:
    units = Units.of_label(table.scene.get("units"))
    drawn = RichTable(
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
        collapse_padding=True,
        pad_edge=False,
        title=table.study.name,
        title_justify="left",
    )
    for heading in ("algorithm", "slave", *keys):
        drawn.add_column(heading, no_wrap=True)
    drawn.add_column("level", justify="right")
    drawn.add_column("status", no_wrap=True)
    for column in columns:
        drawn.add_column(_heading(column, units), justify="right", no_wrap=True)
    numbers = {row.name: number for number, row in enumerate(table.failed, start=1)}
    for row, following in zip(table.rows, [*table.rows[1:], None], strict=True):
        cells = [quantity(row[column.name], column.unit, column.digits) for column in columns]
        chosen = [str(row.choices.get(key, "")) for key in keys]
        status = _status(row, numbers.get(row.name))
        ends = following is not None and following.refines != row.refines
        drawn.add_row(row.algorithm, row.slave, *chosen, str(row.level), status, *cells, end_section=ends)
    return drawn


def _heading(column: Column, units: Units) -> Text:
    unit = heading_unit(column.unit, units[column.unit] if column.unit else "")
    text = Text(_SHORT.get(column.name, column.title))
    return text.append(f"\n{unit}", style="dim") if unit else text


def _status(row: Row, number: int | None) -> Text:
    mark = f" {number}".translate(_RAISED) if number is not None else ""
    status = Text(row.status + mark, style=_COLOURS.get(row.status, "red"))
    return status.append(" !", style="bold yellow") if row.warnings else status


def _notes(table: Table, left_out: Sequence[str]) -> list[Text]:
    notes = [
        Text.assemble((f"{number} ".translate(_RAISED), "bold"), f"{_who(row)}, {row.status}: {row.reason}")
        for number, row in enumerate(table.failed, start=1)
    ]
    notes += _warnings(table)
    notes.append(_reference_note(table))
    if left_out:
        notes.append(Text("not shown for lack of width: " + ", ".join(left_out), style="dim"))
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
        return Text(f"no pressure error: {why}", style="dim")
    known = percent(reference.pressure_uncertainty)
    return Text(f"reference: {reference.title}; its pressure is known to {known} %", style="dim")
