"""All numbers of a comparison on a terminal, and where the time of its runs went."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table as RichTable
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.reports.numbers import heading_unit, quantity
from contactlab.reports.terminal import Terminal
from contactlab.reports.times_table import HEADS, times_rows
from contactlab.studies.table import Row, Table


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
        values = [row[column.name] for row in rows]
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
