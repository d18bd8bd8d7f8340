"""Figures of a study of cases: error against cost with the front, and the share of targets that is solved in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from contactlab.accuracy.lines import Line, front
from contactlab.accuracy.run import Accuracy, Asked
from contactlab.accuracy.solved import BEST, Solved
from contactlab.api.drawing.colours import REFERENCE, styles
from contactlab.reports.figures import FAINT, INK, MUTED, house_style, note, span_at_least
from contactlab.reports.numbers import percent, significant

_DASHES: Any = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (5, 1, 1, 1)), (0, (8, 2, 1, 2)), (0, (3, 1)))
_MARKERS = ("o", "s", "D", "^", "v", "P")
_COLUMNS = 4
_ENTRY = 2.6  # inches that an entry of the legend takes
_BESIDE, _WIDE_ENTRY = 3, 3.0  # entries with numbers beside each other, and inches that one takes
_LEAST_RANGE = 5.0  # of an axis, largest over least: points that are closer than that look it


@dataclass(frozen=True)
class Look:
    """How a contender is drawn: its algorithm by colour, its element by marker, its way by the dashes."""

    colour: str
    marker: str
    dashes: Any


def looks(found: Accuracy) -> dict[str, Look]:
    """A look for each contender."""
    parts = {name: parts_of(name) for name in found.contenders}
    colours = styles(algorithm for algorithm, _, _ in parts.values())
    elements = list(dict.fromkeys(element for _, element, _ in parts.values()))
    ways = list(dict.fromkeys(way for _, _, way in parts.values()))
    return {
        name: Look(
            colours[algorithm].colour,
            _MARKERS[elements.index(element) % len(_MARKERS)],
            _DASHES[ways.index(way) % len(_DASHES)],
        )
        for name, (algorithm, element, way) in parts.items()
    }


def parts_of(contender: str) -> tuple[str, str, str]:
    """Algorithm, element and way of a contender."""
    algorithm, element, way = contender.split(" ", 2)
    return algorithm, element, way


def cost_figure(found: Accuracy, lines: Sequence[Line]) -> Figure:
    """A panel per case; lines are contenders with their better slave, the grey step is the front."""
    chosen = looks(found)
    cases = [asked for asked in found.asked if any(line.finished for line in lines if line.case == asked.label)]
    rows = max(1, math.ceil(len(cases) / _COLUMNS))
    columns = min(_COLUMNS, max(1, len(cases)))
    with house_style():
        width = max(7.0, 3.4 * columns)
        drawn = {line.contender for line in lines if line.finished}
        beside = min(_COLUMNS, int(width / _ENTRY))
        beneath = math.ceil((len(drawn) + 3) / beside)  # and three entries that tell of all
        figure = Figure(figsize=(width, 0.9 + 0.17 * beneath + 2.75 * rows), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, asked in zip(grid, cases, strict=False):
            _panel(axes, asked, [line for line in lines if line.case == asked.label], chosen)
        for axes in grid[len(cases) :]:
            axes.set_axis_off()
        if not cases:
            note(grid[0], "no run came to its end")
        for axes in grid[max(0, len(cases) - columns) : len(cases)]:
            axes.set_xlabel("CPU time [s]", fontsize=8.5)
        for axes in grid[: len(cases) : columns]:
            axes.set_ylabel("relative error [%]", fontsize=8.5)
        _legend(figure, {name: look for name, look in chosen.items() if name in drawn}, beside)
    return figure


def _panel(axes: Axes, asked: Asked, lines: Sequence[Line], chosen: dict[str, Look]) -> None:
    axes.set_title(asked.label, pad=6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    best = front(lines)
    if best:
        axes.step(
            [p.cost for p in best],
            [p.error for p in best],
            where="post",
            color=INK,
            linewidth=5.0,
            alpha=0.16,
            zorder=1,
        )
    for line in better(lines):
        look = chosen[line.contender]
        cost, error = [p.cost for p in line.finished], [p.error for p in line.finished]
        axes.plot(
            cost, error, color=look.colour, linestyle=look.dashes, marker=look.marker, markersize=4.5, linewidth=1.1,
            markerfacecolor=look.colour if line.slave == "declared" else "none", zorder=2, alpha=0.9,
        )  # fmt: skip
    _scales(axes)
    if asked.uncertainty > 0.0:
        bottom, top = axes.get_ylim()
        if 3.0 * asked.uncertainty > bottom:
            axes.axhspan(
                bottom, min(3.0 * asked.uncertainty, top), color=REFERENCE, alpha=0.18, linewidth=0.0, zorder=0
            )
            axes.set_ylim(bottom, top)


def better(lines: Sequence[Line]) -> list[Line]:
    """Of each contender the slave with the smaller error times cost, over its finest finished points."""
    found: dict[str, Line] = {}
    for line in lines:
        if not line.finished:
            continue
        before = found.get(line.contender)
        if before is None or _worth(line) < _worth(before):
            found[line.contender] = line
    return list(found.values())


def _worth(line: Line) -> float:
    return float(np.mean([math.log(max(p.error, 1e-14) * p.cost) for p in line.finished]))


def _scales(axes: Axes) -> None:
    span_at_least(axes, _LEAST_RANGE)
    for axis, text in ((axes.xaxis, significant), (axes.yaxis, percent)):
        low, high = axes.get_xlim() if axis is axes.xaxis else axes.get_ylim()
        subdivisions = (1.0,) if high / low > 60.0 else (1.0, 3.0) if high / low > 8.0 else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=subdivisions, numticks=9))
        axis.set_major_formatter(FuncFormatter(lambda value, _, text=text: text(value, 1)))
        axis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=8)


def _legend(figure: Figure, chosen: dict[str, Look], columns: int) -> None:
    entries = [
        Line2D([], [], color=look.colour, linestyle=look.dashes, marker=look.marker, markersize=5, label=name)
        for name, look in chosen.items()
    ]
    entries.append(Line2D([], [], color=INK, linewidth=5.0, alpha=0.16, label="front: nothing is better and cheaper"))
    entries.append(Line2D([], [], color=REFERENCE, linewidth=7.0, alpha=0.3, label="the reference cannot tell"))
    entries.append(
        Line2D([], [], color=MUTED, marker="o", markerfacecolor="none", linestyle="none", label="slaves exchanged")
    )
    figure.legend(handles=entries, loc="outside lower center", ncols=columns, fontsize=8, labelcolor=MUTED)


def solved_figure(found: Accuracy, profiles: Sequence[Solved]) -> Figure:
    """Share of the targets that each contender has met within a CPU time."""
    chosen = looks(found)
    times = [time for one in profiles for time in one.times if time > 0.0]
    with house_style():
        beneath = math.ceil(len(profiles) / _BESIDE)
        figure = Figure(figsize=(_BESIDE * _WIDE_ENTRY, 3.9 + 0.16 * beneath), layout="constrained")
        axes = figure.subplots()
        if times:
            axes.set_xscale("log")
            low, high = 0.7 * min(times), 1.5 * max(times)
            for one in sorted(profiles, key=lambda p: -p.share(high)):
                _profile(axes, one, chosen.get(one.contender), low, high)
            axes.set_xlim(low, high)
        else:
            note(axes, "no target was met")
        axes.set_ylim(0.0, 1.02)
        axes.set_xlabel("CPU time [s]")
        axes.set_ylabel("share of the targets that were met")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100.0 * value:.0f} %"))
        if times:
            figure.legend(loc="outside lower center", ncols=_BESIDE, fontsize=7.5, labelcolor=MUTED)
    return figure


def _profile(axes: Axes, one: Solved, look: Look | None, low: float, high: float) -> None:
    x = [low, *one.times, high]
    y = [0.0, *((k + 1) / one.asked for k in range(len(one.times))), len(one.times) / one.asked]
    label = f"{one.contender}: {len(one.times)} of {one.put}"
    if one.contender == BEST:
        label = f"{BEST}: {len(one.times)} of {one.asked}"
    if one.contender == BEST or look is None:
        axes.step(x, y, where="post", color=FAINT, linewidth=4.0, zorder=1, label=label)
        return
    axes.step(x, y, where="post", color=look.colour, linestyle=look.dashes, linewidth=1.3, zorder=2, label=label)
