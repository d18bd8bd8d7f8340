"""Cost of an effect against the error of omitting it: what a scene needs, and what it could spare."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from contactlab.reports.breakdown_table import EXPLANATION, effects_sheet, reasons, sentence
from contactlab.reports.figures import ALARM, INK, MUTED, house_style, laid_out, note, save
from contactlab.reports.html import document, figure_section, machine_section, scene_section, section
from contactlab.reports.numbers import percent
from contactlab.studies.cost_breakdown import CostBreakdown, EffectCost
from contactlab.studies.table import Table

FLOOR = 1e-5  # share: what changes less is drawn here
NEEDED = 1e-2  # share of the answer beyond which an effect is called needed in the plot
DEAR = 0.05  # share of the run's CPU time beyond which an effect is called dear
DECLARED, ADDED = "#0072B2", "#D55E00"


def breakdown_figure(breakdown: CostBreakdown) -> Figure:
    """A point for each effect: to the right it costs more, further up the answer needs it more."""
    drawn = [c for c in breakdown.effects if not math.isnan(c.error + c.run_s) and breakdown.run_s > 0.0]
    with house_style():
        figure = Figure(figsize=(8.6, 5.2), layout="constrained")
        axes = figure.subplots()
        for cost in drawn:
            colour = DECLARED if cost.declared else ADDED
            face = colour if cost.declared else "none"
            axes.plot(*_place(cost, breakdown), marker="o", markersize=9, color=colour, markerfacecolor=face, zorder=3)
        _scales(axes, drawn, breakdown)
        _regions(axes)
        _label(axes, drawn, breakdown)
        _legend(axes)
        left_out = [f"{cost.effect}: {cost.status}" for cost in breakdown.effects if cost not in drawn]
        if not drawn:
            note(axes, "no run shows the cost and the influence of an effect")
        elif left_out:
            text = textwrap.fill(f"without a point: {'; '.join(left_out)}", 110)
            axes.set_title(text, fontsize=8.5, fontweight="normal", color=ALARM)
    return figure


def _place(cost: EffectCost, breakdown: CostBreakdown) -> tuple[float, float]:
    return 100.0 * cost.run_s / breakdown.run_s, 100.0 * max(cost.error, FLOOR)


_BESIDE: Any = (((9, 4), "left"), ((-9, 4), "right"), ((9, -13), "left"), ((-9, -13), "right"))
_LETTER, _LINE = 0.0115, 0.04  # size of a letter in parts of the axes


def _label(axes: Axes, drawn: Sequence[EffectCost], breakdown: CostBreakdown) -> None:
    """The name of each effect on that side of its point where it covers no other name or point."""
    to_axes = axes.transData + axes.transAxes.inverted()
    places = [tuple(to_axes.transform(_place(cost, breakdown))) for cost in drawn]
    taken: list[tuple[float, ...]] = [(x - 0.01, x + 0.01, y - 0.015, y + 0.015) for x, y in places]
    for cost, (x, y) in zip(drawn, places, strict=True):
        boxes = [_box(x, y, len(cost.effect), *side) for side in _BESIDE]
        free = [k for k, box in enumerate(boxes) if not any(_cover(box, other) for other in taken)]
        chosen = free[0] if free else 0
        taken.append(boxes[chosen])
        offset, across = _BESIDE[chosen]
        where = {"xytext": offset, "textcoords": "offset points", "ha": across}
        axes.annotate(cost.effect, _place(cost, breakdown), color=INK, fontsize=9, **where)


def _box(x: float, y: float, letters: int, offset: tuple[int, int], across: str) -> tuple[float, ...]:
    """Left, right, bottom and top of a name, in parts of the axes; far outside where it would leave them."""
    begin = x + 0.02 if across == "left" else x - 0.02 - _LETTER * letters
    end, low = begin + _LETTER * letters, y + (0.005 if offset[1] > 0 else -_LINE)
    return (begin, end, low, low + _LINE) if begin >= 0.0 and end <= 1.0 else (-9.0, 9.0, -9.0, 9.0)


def _cover(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]


def _scales(axes: Axes, drawn: Sequence[EffectCost], breakdown: CostBreakdown) -> None:
    axes.set_xlabel("cost: share of the CPU time of the scene as declared [%]")
    axes.set_ylabel("error of omitting it: largest change of\nforce, pressure and energy [%]")
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.6)
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_major_formatter(FuncFormatter(_error_label))
    places = [_place(cost, breakdown) for cost in drawn]
    low, high = min([x for x, _ in places], default=0.0), max([x for x, _ in places], default=1.0)
    axes.set_xlim(min(-1.5, 3.0 * low), max(30.0, 6.0 * high))
    axes.set_ylim(100.0 * FLOOR / 2.0, max(200.0, 3.0 * max([y for _, y in places], default=1.0)))


def _error_label(value: float, _: object) -> str:
    return f"≤ {percent(FLOOR, 1)}" if math.isclose(value, 100.0 * FLOOR) else f"{value:g}"


def _regions(axes: Axes) -> None:
    """Label the four corners of the plot with what they mean."""
    axes.axhline(100.0 * NEEDED, color=MUTED, linewidth=0.8, linestyle=(0, (4, 3)), zorder=0)
    axes.axvline(100.0 * DEAR, color=MUTED, linewidth=0.8, linestyle=(0, (4, 3)), zorder=0)
    for x, y, across, text in (
        (0.99, 0.98, "right", "expensive and needed"),
        (0.99, 0.02, "right", "expensive, can be switched off"),
        (0.01, 0.98, "left", "cheap and needed"),
        (0.01, 0.02, "left", "cheap, can be switched off"),
    ):
        up = "top" if y > 0.5 else "bottom"
        axes.text(x, y, text, transform=axes.transAxes, ha=across, va=up, color=MUTED, fontsize=9, style="italic")


def _legend(axes: Axes) -> None:
    entries = [
        Line2D([], [], color=DECLARED, marker="o", linestyle="none", markersize=8, label="in the scene: removed"),
        Line2D(
            [], [], color=ADDED, marker="o", markerfacecolor="none", linestyle="none", markersize=8,
            label="not in the scene: added",
        ),
    ]  # fmt: skip
    axes.legend(handles=entries, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2)


_PLOT = (
    "Each point is an effect. Full: the scene declares it, and it was removed. Hollow: the scene omits it, "
    "and it was added. Points at the top matter to the answer; points at the right are expensive."
)


def write_breakdown_report(table: Table, breakdown: CostBreakdown, folder: Path) -> None:
    """Write `report.html` and the plot (SVG and PNG) into the folder."""
    figure = laid_out(breakdown_figure(breakdown))
    save(figure, folder, "bill")
    notes = "".join(f'<p class="note">{escape(text)}</p>\n' for text in reasons(breakdown.effects))
    head = (
        f'<header>\n<h1>{escape(table.study.name)}</h1>\n<p class="lead">{escape(sentence(breakdown))}</p>\n</header>'
    )
    explanation = f'<p class="note">{escape(EXPLANATION)}</p>\n'
    sections = [
        head,
        section("Cost and influence of each effect", effects_sheet(breakdown).html() + explanation + notes),
        figure_section({"bill": figure}, "bill", "Which effects the scene needs", _PLOT, narrow=True),
        scene_section(table),
        machine_section(table),
    ]
    (folder / "report.html").write_text(document(table.study.name, sections), encoding="utf-8")
