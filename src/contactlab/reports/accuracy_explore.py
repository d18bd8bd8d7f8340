"""Error against cost as a plot to look into: hover, zoom, filter, and a click that leads to a run's page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from bokeh.embed import components
from bokeh.models import (
    BoxAnnotation,
    ColumnDataSource,
    CustomJS,
    CustomJSTickFormatter,
    HoverTool,
    TapTool,
)  # fmt: skip
from bokeh.plotting import figure
from bokeh.resources import Resources

from contactlab.accuracy.lines import CLEAR, Line, front
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy
from contactlab.reports.accuracy_plots import STOPPED, Look, looks, parts_of
from contactlab.reports.html import filled

Place = tuple[str, str, str, int]
"""Case, contender, slave, level of a point."""
Columns = dict[str, list[Any]]

_MARKERS = {"o": "circle", "s": "square", "D": "diamond", "^": "triangle", "v": "inverted_triangle", "P": "cross"}
_DASHES = ("solid", "dashed", "dotted", "dotdash", "dashdot", [8, 4])
_TIPS = [
    ("", "@contender, @slave, level @level"), ("error", "@error"), ("CPU", "@x{0.000} s"),
    ("counts", "@counts"),
]  # fmt: skip
_TAP = (
    "const i = source.selected.indices[0]; source.selected.indices = [];"
    "if (i !== undefined && source.data.page[i]) window.open(source.data.page[i], '_blank')"
)
GREY = "#7d8590"  # read on white and on black
_TICK = "return tick >= 0.001 ? String(Number(tick.toPrecision(3))) : tick.toExponential(0)"


def explore_section(found: Accuracy, lines: Sequence[Line], pages: Mapping[Place, str]) -> str:
    """The plot with controls for its case, algorithms, elements, ways and slaves; empty if no run finished."""
    cases = [asked for asked in found.asked if any(line.finished for line in lines if line.case == asked.label)]
    if not cases:
        return ""
    script, division = components(_plot(found, lines, pages, cases[0].label))
    parts = [parts_of(name) for name in found.contenders]
    groups = [("algorithm", 0), ("element", 1), ("way", 2)]
    filters = [(name, list(dict.fromkeys(each[k] for each in parts))) for name, k in groups]
    filters.append(("slave", ["declared", "exchanged"]))
    clear = {asked.label: 100.0 * CLEAR * asked.uncertainty for asked in cases}
    return filled("explore.html", library=library(), script=script, division=division, clear=clear, filters=filters)


@cache
def library() -> str:
    """The plot library as scripts that need no other file (1.3 MB)."""
    return str(Resources(mode="inline", components=["bokeh"]).render())


def page_figure(**settings: Any) -> Any:
    """A figure as wide as the page, without a background; `settings` are passed to Bokeh's figure."""
    plot = figure(sizing_mode="stretch_width", background_fill_alpha=0.0, border_fill_alpha=0.0, **settings)
    for axis in (plot.xaxis[0], plot.yaxis[0]):
        axis.update(axis_label_text_color=GREY, major_label_text_color=GREY, axis_line_color=GREY)
    plot.title.text_color = GREY
    plot.grid.grid_line_alpha = 0.25
    return plot


def _plot(found: Accuracy, lines: Sequence[Line], pages: Mapping[Place, str], case: str) -> Any:
    plot = page_figure(
        x_axis_type="log", y_axis_type="log", height=460, name="explore", tools="pan,wheel_zoom,box_zoom,reset,save",
        active_drag="box_zoom", x_axis_label="CPU time [s]", y_axis_label="relative error [%]", outline_line_alpha=0.3,
    )  # fmt: skip
    for axis in (plot.xaxis[0], plot.yaxis[0]):
        axis.formatter = CustomJSTickFormatter(code=_TICK)
    chosen = looks(found)
    fronts, curves, points = _fronts(lines), _curves(lines, chosen), _points(lines, chosen, pages, found.study.limit)
    shown = {name: _source(f"{name}-shown", _of_case(all_of, case)) for name, all_of in
             (("front", fronts), ("curves", curves), ("points", points))}  # fmt: skip
    plot.multi_line("xs", "ys", source=shown["front"], color=GREY, line_width=7, alpha=0.3)
    plot.multi_line("xs", "ys", source=shown["curves"], color="colour", line_dash="dash", line_width=1.4)
    dots = plot.scatter("x", "y", source=shown["points"], marker="marker", size=9, line_color="colour",
                        fill_color="colour", fill_alpha="fill")  # fmt: skip
    plot.add_tools(HoverTool(renderers=[dots], tooltips=_TIPS), TapTool(
        renderers=[dots], callback=CustomJS(args={"source": shown["points"]}, code=_TAP)))  # fmt: skip
    top = next(100.0 * CLEAR * asked.uncertainty for asked in found.asked if asked.label == case)
    plot.add_layout(BoxAnnotation(top=top, fill_color=GREY, fill_alpha=0.15, line_alpha=0.0, name="unclear"))
    every = {name: _source(f"{name}-all", all_of) for name, all_of in
             (("front", fronts), ("curves", curves), ("points", points))}  # fmt: skip
    plot.tags = list(every.values())
    return plot


def _source(name: str, columns: Columns) -> ColumnDataSource:
    return ColumnDataSource(columns, name=name)


def _of_case(columns: Columns, case: str) -> Columns:
    kept = [row for row, name in enumerate(columns["case"]) if name == case]
    return {name: [values[row] for row in kept] for name, values in columns.items()}


def _fronts(lines: Sequence[Line]) -> Columns:
    """A step line for each case: what nothing is better and cheaper than."""
    columns: Columns = {"case": [], "xs": [], "ys": []}
    for case in dict.fromkeys(line.case for line in lines):
        best = front([line for line in lines if line.case == case])
        x = [value for k, p in enumerate(best) for value in ((best[k].cost,) if k == 0 else (p.cost, p.cost))]
        y = [value for p in best for value in (100.0 * p.error, 100.0 * p.error)][: len(x)]
        columns["case"].append(case)
        columns["xs"].append(x)
        columns["ys"].append(y)
    return columns


def _curves(lines: Sequence[Line], chosen: Mapping[str, Look]) -> Columns:
    ways = list(dict.fromkeys(parts_of(name)[2] for name in chosen))
    rows = [
        {
            **_labels(line), "colour": chosen[line.contender].colour,
            "dash": _DASHES[ways.index(parts_of(line.contender)[2]) % len(_DASHES)],
            "xs": [p.cost for p in line.finished], "ys": [100.0 * max(p.error, 1e-14) for p in line.finished],
        }
        for line in lines if line.finished
    ]  # fmt: skip
    return _columns(rows)


def _points(lines: Sequence[Line], chosen: Mapping[str, Look], pages: Mapping[Place, str], limit: float) -> Columns:
    """Finished points, and lost ones above them."""
    above: dict[str, float] = {}
    for line in lines:
        above[line.case] = max([above.get(line.case, 0.0), *(2.0 * p.error for p in line.finished)])
    rows = [
        {
            **_labels(line), "level": p.level, "x": p.cost if ended else line.lost_at(p, limit),
            "y": 100.0 * max(p.error if ended else above[line.case], 1e-14), "colour": look.colour,
            "marker": _MARKERS[look.marker] if ended else "triangle_pin" if p.status in STOPPED else "x",
            "fill": 0.9 if line.slave == "declared" else 0.0,
            "counts": ", ".join(f"{value:.0f} {name}" for name, value in p.counts.items() if value),
            "error": f"{100.0 * p.error:.3g} %{_best(p)}" if ended else f"{p.status}: {p.reason}",
            "page": pages.get((line.case, line.contender, line.slave, p.level), ""),
        }
        for line in lines for look in (chosen[line.contender],)
        for ended, points in ((True, line.finished), (False, line.lost)) for p in points
    ]  # fmt: skip
    return _columns(rows)


def _labels(line: Line) -> dict[str, Any]:
    algorithm, element, way = parts_of(line.contender)
    return {
        "case": line.case, "contender": line.contender, "slave": line.slave,
        "algorithm": algorithm, "element": element, "way": way,
    }  # fmt: skip


def _best(point: Point) -> str:
    """Return the smallest error that the nodes allow, if it is known."""
    return "" if math.isnan(point.best) else f"; best on these nodes {100.0 * point.best:.3g} %"


def _columns(rows: Sequence[Mapping[str, Any]]) -> Columns:
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}
