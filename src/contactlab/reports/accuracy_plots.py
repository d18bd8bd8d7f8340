"""Figures of a study of cases: error against cost with the front, and the share of targets that is solved in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter

from contactlab.accuracy.lines import CLEAR, Line, better, front
from contactlab.accuracy.run import Accuracy, Asked
from contactlab.accuracy.solved import BEST, Solved
from contactlab.api.drawing.colours import REFERENCE, styles
from contactlab.reports.figures import FAINT, INK, MUTED, house_style, log_axes, note

_DASHES: Any = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (5, 1, 1, 1)), (0, (8, 2, 1, 2)), (0, (3, 1)))
_MARKERS = ("o", "s", "D", "^", "v", "P")
_COLUMNS = 3
_ENTRY = 2.6  # inches that an entry of the legend takes
_BESIDE, _WIDE_ENTRY = 3, 3.0  # entries with numbers in a row, and inches that one takes
_UNCLEAR: Any = {"facecolor": "none", "edgecolor": REFERENCE, "alpha": 0.35, "hatch": "////", "linewidth": 0.0}
_STRIP = 0.05  # of the height that points take, for the marks of an algorithm's lost runs
STOPPED = ("timed-out", "over-limit")


@dataclass(frozen=True)
class Look:
    """Line style of a contender: its algorithm by colour, its element by marker, its way by the dashes."""

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
        width = max(7.0, 4.2 * columns)
        drawn = [name for name in found.contenders if any(line.contender == name for line in lines)]
        beside = min(_COLUMNS, int(width / _ENTRY))
        beneath = math.ceil((sum(len({parts_of(name)[k] for name in drawn}) for k in range(3)) + 5) / beside)
        figure = Figure(figsize=(width, 0.9 + 0.17 * beneath + 3.3 * rows), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, asked in zip(grid, cases, strict=False):
            _panel(axes, asked, [line for line in lines if line.case == asked.label], chosen, found.study.limit)
        for axes in grid[len(cases) :]:
            axes.set_axis_off()
        if not cases:
            note(grid[0], "no run finished")
        for axes in grid[max(0, len(cases) - columns) : len(cases)]:
            axes.set_xlabel("CPU time [s]", fontsize=8.5)
        for axes in grid[: len(cases) : columns]:
            axes.set_ylabel("relative error [%]", fontsize=8.5)
        _legend(figure, drawn, chosen, beside)
    return figure


def _panel(axes: Axes, asked: Asked, lines: Sequence[Line], chosen: dict[str, Look], limit: float) -> None:
    axes.set_title(asked.label, pad=6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    best = front(lines)
    axes.step([p.cost for p in best], [p.error for p in best], where="post", color=INK, linewidth=5.0, alpha=0.16,
              zorder=1)  # fmt: skip
    for line in better(lines):
        look = chosen[line.contender]
        axes.plot(
            [p.cost for p in line.finished], [p.error for p in line.finished], color=look.colour,
            linestyle=look.dashes, marker=look.marker, markersize=4.5, linewidth=1.1,
            markerfacecolor=look.colour if line.slave == "declared" else "none", zorder=2, alpha=0.9,
        )  # fmt: skip
        for point in line.finished:
            axes.annotate(
                str(point.level), (point.cost, point.error), (2.5, 2.5), textcoords="offset points", fontsize=5.5,
                color=look.colour, fontweight="bold" if point in best else "normal", zorder=3,
            )  # fmt: skip
    _lost(axes, lines, chosen, limit)
    log_axes(axes)
    axes.tick_params(labelsize=8)
    if asked.uncertainty > 0.0:
        bottom, top = axes.get_ylim()
        if CLEAR * asked.uncertainty > bottom:
            axes.axhspan(bottom, min(CLEAR * asked.uncertainty, top), **_UNCLEAR, zorder=0)
            axes.set_ylim(bottom, top)


def _lost(axes: Axes, lines: Sequence[Line], chosen: dict[str, Look], limit: float) -> None:
    """Marks above the points for runs that failed or were stopped, a row per algorithm."""
    marks = {(look.colour, line.lost_at(point, limit), point.status) for line in lines for point in line.lost
             for look in (chosen[line.contender],)}  # fmt: skip
    if not marks:
        return
    colours = list(dict.fromkeys(look.colour for look in chosen.values()))
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top * (top / bottom) ** (_STRIP * len(colours)))
    height = _STRIP * len(colours) / (1.0 + _STRIP * len(colours))
    for colour, cost, status in marks:
        y = 1.0 - height * (colours.index(colour) + 0.5) / len(colours)
        marker = ">" if status in STOPPED else "x"
        axes.plot(cost, y, marker, color=colour, markersize=3.8, transform=axes.get_xaxis_transform(), zorder=3)


def _legend(figure: Figure, names: Sequence[str], chosen: dict[str, Look], columns: int) -> None:
    """Colours are algorithms, dashes ways, markers elements: an entry each, and the marks that all share."""
    algorithms, elements, ways = ({parts_of(name)[k]: chosen[name] for name in names} for k in range(3))
    entries: list[Artist] = [
        Line2D([], [], color=look.colour, linewidth=4.0, label=name) for name, look in algorithms.items()
    ]
    entries += [Line2D([], [], color=INK, linestyle=look.dashes, linewidth=1.6, label=f"line: {name}")
                for name, look in ways.items()]  # fmt: skip

    def mark(marker: str, label: str, face: str = MUTED) -> Line2D:
        return Line2D([], [], color=MUTED, marker=marker, markerfacecolor=face, linestyle="none", label=label)

    entries += [mark(look.marker, f"point: {name}") for name, look in elements.items()]
    entries += [mark("o", "slaves exchanged", "none"), mark("x", "failed"), mark(">", "stopped at its limit")]
    entries.append(Line2D([], [], color=INK, linewidth=5.0, alpha=0.16, label="front: nothing better is cheaper"))
    entries.append(Patch(**_UNCLEAR, label="below the uncertainty of the reference"))
    figure.legend(
        handles=entries, loc="outside lower center", ncols=columns, fontsize=8, labelcolor=MUTED, handlelength=3.4
    )


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
