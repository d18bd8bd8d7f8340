"""The table of the report page: sortable, every run in it, reasons beneath what failed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from contactlab.api.drawing.colours import Style
from contactlab.api.drawing.units import Units
from contactlab.reports.numbers import heading_unit, quantity
from contactlab.reports.table import USUAL
from contactlab.studies.columns import Column
from contactlab.studies.table import Row, Table


def runs_table(table: Table, styles: dict[str, Style]) -> str:
    """The table as HTML; columns beyond the usual ones are shown on demand."""
    units = Units.of_label(table.scene.get("units"))
    keys = list(dict.fromkeys(key for row in table.rows for key in row.choices))
    columns = [
        c for c in table.measures if any(not math.isnan(row.measures.get(c.name, math.nan)) for row in table.rows)
    ]
    usual = set(table.study.measures or USUAL)
    heads = [_text_head(name) for name in ("algorithm", "slave", *keys)]
    heads += [_head("level", "", "Multiplier of all cell counts."), _text_head("status")]
    heads += [_head(c.title, _unit(c, units), c.meaning, extra=c.name not in usual) for c in columns]
    bodies = [_run(row, columns, keys, usual, styles[row.algorithm], len(heads), table) for row in table.rows]
    return (
        '<p><button class="switch" type="button" data-all="runs">Show all columns</button></p>\n'
        '<div class="scroll"><table class="sortable" id="runs">\n'
        f"<thead><tr>{''.join(heads)}</tr></thead>\n" + "\n".join(bodies) + "\n</table></div>"
    )


def _unit(column: Column, units: Units) -> str:
    return heading_unit(column.unit, units[column.unit] if column.unit else "")


def _text_head(name: str) -> str:
    return f'<th class="text" scope="col"><button type="button">{escape(name)}</button></th>'


def _head(title: str, unit: str, meaning: str, extra: bool = False) -> str:
    below = f'<span class="unit">{escape(unit)}</span>' if unit else ""
    kind = ' class="extra"' if extra else ""
    return (
        f'<th scope="col"{kind} title="{escape(meaning)}">'
        f'<button type="button">{escape(title)}</button>{below}</th>'
    )  # fmt: skip


def _run(
    row: Row, columns: Sequence[Column], keys: Sequence[str], usual: set[str], style: Style, width: int, table: Table
) -> str:
    cells = [_algorithm(row, style, table), _text(row.slave)]
    cells += [_text(row.choices.get(key, "")) for key in keys]
    cells += [
        _number(row.level, str(row.level)),
        f'<td class="text"><span class="status {row.status}">{row.status}</span></td>',
    ]
    for column in columns:
        value = row.measures.get(column.name, math.nan)
        cells.append(_number(value, quantity(value, column.unit, column.digits), extra=column.name not in usual))
    kind = ' class="refines"' if row.refines else ""
    return f'<tbody class="run"><tr{kind}>{"".join(cells)}</tr>{_below(row, width)}</tbody>'


def _below(row: Row, width: int) -> str:
    """Why a run did not finish, and what it says against itself."""
    lines = [escape(row.reason)] if row.reason else []
    lines += [f'<b class="warned">{escape(w.code)}</b>: {escape(w.text)}' for w in row.warnings]
    return "".join(f'<tr class="reason"><td colspan="{width}"><span>{line}</span></td></tr>' for line in lines)


def _algorithm(row: Row, style: Style, table: Table) -> str:
    name = f'<span class="swatch" style="--colour: {style.colour}"></span>{escape(row.algorithm)}'
    if table.folder is not None and (table.folder / "runs" / row.name).is_dir():
        name = f'<a href="runs/{escape(row.name)}/">{name}</a>'
    return f'<td class="text">{name}</td>'


def _text(value: object) -> str:
    return f'<td class="text">{escape(str(value))}</td>'


def _number(value: float, text: str, extra: bool = False) -> str:
    known = "" if math.isnan(value) else repr(value)
    kind = ' class="extra"' if extra else ""
    return f'<td{kind} data-value="{known}">{escape(text)}</td>'
