"""Contact pressure of every run against the reference: small multiples, a column per algorithm."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import FIELD, REFERENCE, Style, styles
from contactlab.api.drawing.units import Units
from contactlab.reports.figures import ALARM, INK, MUTED, house_style, note
from contactlab.reports.force_plot import label_of
from contactlab.reports.notebook.canvas import Plot, figure_of, with_unit
from contactlab.reports.numbers import percent, significant
from contactlab.reports.series import series_of, series_styles
from contactlab.results.shown_pressure import shown_pressure
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference
from contactlab.studies.table import Row, Table
from contactlab.studies.varied_text import varied_text

_MARGIN = 0.2  # of the pressed length, shown on either side
_DASHES = (0, (4, 1.5))
BESIDE = 3  # panels in a row
_PRESSED = 0.01  # of the largest pressure: what is below it is no contact worth a wider plot
_HEADROOM = 1.3  # of the largest reference pressure; higher peaks are cut and their value is written


def is_map(table: Table) -> bool:
    """Return whether there are too many panels for separate plots."""
    algorithms, cases = _columns_and_rows(table.main)
    return len(algorithms) * len(cases) > PANELS


def _columns_and_rows(rows: Sequence[Row]) -> tuple[list[str], list[str]]:
    return list(dict.fromkeys(row.algorithm for row in rows)), list(dict.fromkeys(_case(row, rows) for row in rows))


def pressure_figure(table: Table, ax: Axes | None = None) -> Figure:
    """A row of panels per slave (and per further choice), a column per algorithm, the same axes in all; else a map.

    Panels of one algorithm alone follow each other in rows of `BESIDE`. All runs are in one plot in axes of the caller.
    """
    if ax is not None:
        return _in_one(table, ax)
    if is_map(table):
        return pressure_map(table)
    rows = table.main
    algorithms, cases = _columns_and_rows(rows)
    found = {(_case(row, rows), row.algorithm): row for row in rows}
    units, chosen = Units.of_label(table.scene.get("units")), styles(row.algorithm for row in table.rows)
    alone = len(algorithms) == 1 and len(cases) > BESIDE
    high, wide = (-(-len(cases) // BESIDE), BESIDE) if alone else (len(cases), len(algorithms))
    with house_style():
        figure = Plot(figsize=(max(7.0, 3.7 * wide), 0.75 + 2.45 * high), layout="constrained")
        grid = figure.subplots(high, wide, sharex=True, sharey=True, squeeze=False)
        places = grid.ravel()[: len(cases)].reshape(-1, 1) if alone else grid
        for axes in grid.ravel()[len(cases) :] if alone else ():
            axes.set_visible(False)
        for i, case in enumerate(cases):
            for j, algorithm in enumerate(algorithms):
                _panel(places[i, j], found.get((case, algorithm)), table.reference, chosen[algorithm], units)
                if i == 0 and not alone:
                    places[i, j].set_title(algorithm, pad=8)
            if alone:
                places[i, 0].set_title(textwrap.fill(case, 42), pad=6, fontsize=8.5)
            else:
                places[i, 0].set_ylabel(with_unit(f"{textwrap.fill(case, 32)}\npressure", units.pressure))
        if alone:
            figure.supylabel(f"{with_unit('pressure', units.pressure)}, {algorithms[0]}", color=MUTED, fontsize=9.5)
        _limits(grid[0, 0], rows, table.reference)
        _mark_cut_peaks(places, found, cases, algorithms, units)
        figure.supxlabel(with_unit("deformed position x", units.length), color=MUTED, fontsize=9.5)
        entries: list[Patch | Line2D] = []
        if table.reference is not None:
            entries.append(Patch(facecolor=REFERENCE, edgecolor=REFERENCE, alpha=0.4, label="reference"))
        entries.append(Line2D([], [], color=MUTED, marker="o", markersize=3, label="run, nodal values"))
        if any(not row.finished for row in table.main):
            entries.append(Line2D([], [], color=MUTED, linestyle=_DASHES, label="did not finish (last frame)"))
        figure.legend(handles=entries, loc="outside upper right", ncols=len(entries), fontsize=8.5, labelcolor=MUTED)
    return figure


def _in_one(table: Table, axes: Axes) -> Figure:
    """All runs and the reference in axes of the caller; returns their figure."""
    rows = table.main
    units, chosen = Units.of_label(table.scene.get("units")), series_styles(table.rows)
    with house_style():
        if table.reference is not None:
            _draw_reference(axes, table.reference)
        for row in rows:
            if row.curve is not None and len(row.curve.x):
                style = chosen[series_of(row, table.rows)]
                axes.plot(*_line(row), color=style.colour, marker=style.marker,
                          markersize=2.6, linewidth=1.2, linestyle="-" if row.finished else _DASHES,
                          label=label_of(row, rows))  # fmt: skip
        _limits(axes, rows, table.reference)
        axes.set_xlabel(with_unit("deformed position x", units.length))
        axes.set_ylabel(with_unit("pressure", units.pressure))
        axes.legend(fontsize=8.0)
    return figure_of(axes)


def _case(row: Row, rows: Sequence[Row]) -> str:
    """Label of a row of panels."""
    choices = [varied_text(row.choices)] if row.choices else []
    if len({r.level for r in rows}) > 1:
        choices.append(f"level {row.level}")
    return ", ".join([f"slave: {row.slave}", *choices])


def _panel(axes: Axes, row: Row | None, reference: Reference | None, style: Style, units: Units) -> None:
    if reference is not None and (row is None or row.reference in ("", reference.name)):
        _draw_reference(axes, reference)
    if row is None:
        note(axes, "not run")
        return
    if row.curve is not None and len(row.curve.x):
        axes.plot(
            *_line(row),
            color=style.colour,
            marker=style.marker,
            markersize=2.6,
            linewidth=1.3,
            linestyle="-" if row.finished else _DASHES,
            clip_on=True,
        )
    error = row["pressure_error"]
    text = f"error {percent(error)} %" if error == error else ""
    if not row.finished:
        text = "\n".join(filter(None, [row.status, text]))
        if row.curve is None:
            text += "\n" + textwrap.fill(row.reason, 40, max_lines=3, placeholder=" ...")
    axes.text(0.02, 0.96, text, transform=axes.transAxes, ha="left", va="top", color=INK if row.finished else ALARM)


def _line(row: Row) -> tuple[Floats, Floats]:
    """Position and pressure of the pressed part; of all nodes along the chain if that folds over itself."""
    assert row.curve is not None
    pressure = shown_pressure(row.curve)
    if row.profile is None:
        return row.curve.x, pressure
    drawn = Profile.of_nodes(row.curve.x, pressure)
    return drawn.x, drawn.value


def _draw_reference(axes: Axes, reference: Reference) -> None:
    axes.fill_between(reference.profile.x, reference.profile.value, color=REFERENCE, alpha=0.22, linewidth=0.0)
    axes.plot(reference.profile.x, reference.profile.value, color=REFERENCE, linewidth=1.0)


def _limits(axes: Axes, rows: Sequence[Row], reference: Reference | None) -> None:
    profiles = [row.profile for row in rows if row.profile is not None]
    if reference is not None:
        left, right = reference.pressed_range
        top = float(reference.profile.value.max()) * _HEADROOM
    elif profiles:
        left, right = _pressed_range(profiles) or (0.0, 1.0)
        top = float(np.median([p.value.max() for p in profiles])) * _HEADROOM
    else:
        return
    margin = _MARGIN * (right - left)
    axes.set_xlim(left - margin, right + margin)
    if top > 0.0:  # nothing was pressed yet: matplotlib's own limits
        axes.set_ylim(-0.08 * top, top)


def _mark_cut_peaks(
    grid: np.ndarray, found: dict[tuple[str, str], Row], cases: Sequence[str], algorithms: Sequence[str], units: Units
) -> None:
    top = grid[0, 0].get_ylim()[1]
    for i, case in enumerate(cases):
        for j, algorithm in enumerate(algorithms):
            row = found.get((case, algorithm))
            if row is not None and row.curve is not None and row.curve.pressure.max(initial=0.0) > top:
                peak = significant(float(row.curve.pressure.max()), 3)
                text = f"▲ up to {peak} {units.pressure}".rstrip()
                grid[i, j].text(0.98, 0.96, text, transform=grid[i, j].transAxes, ha="right", va="top", color=MUTED)


PANELS = 12
"""Plots that are drawn as separate panels; more runs than that become a map."""
_POINTS = 400
FAR_ABOVE = 4.0  # times the median: peaks of chatter, which would leave all else dark


def pressure_map(table: Table) -> Figure:
    """Position to the right, runs downwards, pressure as colour; a run without a pressure says how it ended."""
    rows = table.main
    units = Units.of_label(table.scene.get("units"))
    known: list[tuple[str, Profile | None, Row | None]] = [(label_of(row, rows), row.profile, row) for row in rows]
    if table.reference is not None:
        known.append(("reference", table.reference.profile, None))
    profiles = [profile for _, profile, _ in known if profile is not None]
    with house_style():
        figure = Plot(figsize=(9.5, 1.2 + 0.19 * len(known)), layout="constrained")
        axes = figure.subplots()
        axes.grid(False)
        if not profiles:
            note(axes, "no run left a pressure")
            return figure
        left, right = _pressed_range(profiles) or (float(profiles[0].x[0]), float(profiles[0].x[-1]))
        left, right = left - 0.1 * (right - left), right + 0.1 * (right - left)
        tops = [float(profile.value.max()) for profile in profiles]
        usual = float(np.median(tops))
        top = max(tops) if max(tops) <= FAR_ABOVE * usual else 1.15 * usual
        at = np.linspace(left, right, _POINTS)
        values = [np.full(_POINTS, np.nan) if profile is None else profile(at) for _, profile, _ in known]
        drawn = axes.imshow(
            np.array(values), aspect="auto", cmap=LinearSegmentedColormap.from_list("field", FIELD), vmin=0.0, vmax=top,
            extent=(left, right, len(known) - 0.5, -0.5), interpolation="nearest",
        )  # fmt: skip
        axes.set_yticks(range(len(known)), [label for label, _, _ in known], fontsize=7.5)
        for tick, (_, _, row) in zip(axes.get_yticklabels(), known, strict=True):
            tick.set_color(INK if row is None or row.finished else ALARM)
        axes.set_xlabel(with_unit("deformed position x", units.length))
        above = any(profile.value.max() > top for profile in profiles)
        bar = figure.colorbar(drawn, ax=axes, pad=0.02, extend="max" if above else "neither")
        bar.set_label(with_unit("pressure", units.pressure), color=MUTED)
    return figure


def _pressed_range(profiles: Sequence[Profile]) -> tuple[float, float] | None:
    """Range of x in which any of them presses; None if nothing does."""
    pressed = [p.x[p.value > _PRESSED * p.value.max()] for p in profiles if np.any(p.value > 0.0)]
    return (float(min(x[0] for x in pressed)), float(max(x[-1] for x in pressed))) if pressed else None
