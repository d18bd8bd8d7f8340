"""Pressure error against CPU seconds over the levels: what accuracy costs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from contactlab.api.drawing.colours import REFERENCE, Style
from contactlab.reports.figures import ALARM, INK, MUTED, house_style, log_axes, note
from contactlab.reports.notebook.canvas import canvas
from contactlab.reports.numbers import percent
from contactlab.reports.series import series_of, series_styles
from contactlab.studies.table import Row, Table

_LINES: Any = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (5, 1, 1, 1)))

_NAMED = 6  # runs without a point that are named above a plot

_FAR_BELOW = 0.4  # of the lowest error drawn: where the reference's own error needs no room in the plot


def cost_figure(table: Table, ax: Axes | None = None) -> Figure:
    """Draw a line per series and slave, a marker per level; runs that did not finish are marked, not dropped."""
    chosen = series_styles(table.rows)
    slaves = list(dict.fromkeys(row.slave for row in table.rows))
    with house_style():
        figure, axes = canvas(ax, 5.0, 8.6)
        drawn = [row for row in table.rows if _drawable(row)]
        for line in _lines(drawn):
            _draw_line(axes, line, chosen[series_of(line[0], table.rows)], slaves.index(line[0].slave))
        axes.set_xlabel("CPU time [s]")
        axes.set_ylabel("pressure error, relative L2 [%]")
        if drawn:
            axes.margins(0.09, 0.12)
            log_axes(axes)
        _draw_uncertainty(axes, table)
        _legend(axes, table, chosen, slaves)
        if drawn:
            # name runs without a point below the plot; of many the first
            missing = [row for row in table.rows if not _drawable(row)]
            if missing:
                told = [
                    f"{series_of(row, missing)}, slave {row.slave}, level {row.level}: {row.status}"
                    for row in missing[:_NAMED]
                ]
                names = "; ".join(told) + (f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else "")
                axes.set_title(
                    textwrap.fill(f"without a point: {names}", 110), fontsize=8.5, fontweight="normal", color=ALARM
                )
        else:
            note(axes, "without a reference there is no error to draw")
    return figure


def _drawable(row: Row) -> bool:
    return bool(row["pressure_error"] > 0.0 and row["cpu_s"] > 0.0)  # false for nan


def _lines(rows: Sequence[Row]) -> list[list[Row]]:
    """Rows that differ in the level alone, from coarse to fine."""
    lines: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        lines.setdefault((row.algorithm, row.slave, str(row.choices)), []).append(row)
    return [sorted(line, key=lambda row: row.level) for line in lines.values()]


def _draw_line(axes: Axes, line: Sequence[Row], style: Style, slave: int) -> None:
    cost, error = [row["cpu_s"] for row in line], [row["pressure_error"] for row in line]
    axes.plot(cost, error, color=style.colour, linestyle=_LINES[slave % len(_LINES)], linewidth=1.2, zorder=2)
    for row, x, y in zip(line, cost, error, strict=True):
        axes.plot(
            x,
            y,
            marker=style.marker,
            markersize=7.5,
            color=style.colour,
            markerfacecolor=style.colour if slave == 0 else "none",
            markeredgewidth=1.4,
            zorder=3,
        )
        if not row.finished:
            axes.plot(x, y, marker="x", markersize=12, markeredgewidth=1.6, color=INK, zorder=4)
    if slave == 0:
        for row, x, y in zip(line, cost, error, strict=True):
            axes.annotate(
                str(row.level), (x, y), (0, 7), textcoords="offset points", ha="center", color=MUTED, fontsize=8.5
            )


def _draw_uncertainty(axes: Axes, table: Table) -> None:
    reference = table.reference
    known = reference.pressure_uncertainty if reference is not None else math.nan
    if not known > 0.0:
        return
    low, high = axes.get_ylim()
    if known < _FAR_BELOW * low:
        text = f"uncertainty of the reference {percent(known)} %"
        axes.text(0.99, 0.01, text, transform=axes.transAxes, ha="right", va="bottom", color=MUTED, fontsize=8.5)
        return
    bottom = min(low, 0.7 * known)
    axes.axhspan(bottom, known, color=REFERENCE, alpha=0.18, linewidth=0.0, zorder=0)
    axes.set_ylim(bottom, high)
    text = f"uncertainty of the reference, {percent(known)} %"
    axes.text(0.01, 0.015, text, transform=axes.transAxes, ha="left", va="bottom", color=MUTED, fontsize=8.5)


def _legend(axes: Axes, table: Table, chosen: dict[str, Style], slaves: Sequence[str]) -> None:
    entries = [
        Line2D([], [], color=style.colour, marker=style.marker, markersize=7, label=name)
        for name, style in chosen.items()
    ]
    for k, slave in enumerate(slaves):
        face = MUTED if k == 0 else "none"
        line = _LINES[k % len(_LINES)]
        entries.append(
            Line2D([], [], color=MUTED, marker="o", markerfacecolor=face, linestyle=line, label=f"slave: {slave}")
        )
    if any(_drawable(row) and not row.finished for row in table.rows):
        entries.append(Line2D([], [], color=INK, marker="x", linestyle="none", markersize=9, label="did not finish"))
    entries.append(Line2D([], [], linestyle="none", marker="$1$", color=MUTED, label="number: mesh level"))
    axes.legend(handles=entries, loc="center left", bbox_to_anchor=(1.01, 0.5), borderaxespad=0.0)
