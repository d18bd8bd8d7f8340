"""Common style of all plots: fonts, greys, files, and colours that follow the dark mode of a page."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final
from weakref import WeakKeyDictionary

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from contactlab.reports.numbers import percent, significant

INK: Final = "#1c2128"
MUTED: Final = "#636c76"
FAINT: Final = "#d5d9de"
PAPER: Final = "#fdfeff"
ALARM: Final = "#c2410c"
"""Greys of a plot, and the colour of failures. On a page each follows a custom property (`inline_svg`)."""

_STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": MUTED,
    "axes.titlecolor": INK,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "text.color": INK,
    "legend.frameon": False,
    "figure.facecolor": PAPER,
    "axes.facecolor": "none",
    "savefig.facecolor": PAPER,
    "svg.fonttype": "path",
    "svg.hashsalt": "contactlab",
}


@contextmanager
def house_style() -> Iterator[None]:
    """Draw figures of the house inside this context."""
    with rc_context(_STYLE):
        yield


def save(figure: Figure, folder: Path, name: str) -> None:
    """Write a figure as `name`.svg and `name`.png into the folder."""
    (folder / f"{name}.svg").write_text(_svg(figure), encoding="utf-8")
    with house_style():
        figure.savefig(folder / f"{name}.png", dpi=160)


_FINAL: WeakKeyDictionary[Figure, list[str]] = WeakKeyDictionary()
"""Figures that nothing changes any more, with their SVG text if it was drawn."""


def laid_out(figure: Figure) -> Figure:
    """The same in its last state: its layout is made once, and its SVG once for a file and a page."""
    with house_style():
        figure.draw_without_rendering()
        engine = figure.get_layout_engine()
        if engine is not None:
            engine.execute(figure)  # after one pass alone, a title above wide axes may be cut off
    figure.set_layout_engine("none")
    _FINAL[figure] = []
    return figure


def is_laid_out(figure: Figure) -> bool:
    """Return whether a figure has its last layout."""
    return figure in _FINAL


def _svg(figure: Figure) -> str:
    """SVG text of a figure."""
    known = _FINAL.get(figure, [])
    if not known:
        buffer = io.StringIO()
        with house_style():
            figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
        known.append(buffer.getvalue())
    return known[0]


def inline_svg(figure: Figure, name: str, description: str) -> str:
    """SVG text for a page: its greys are custom properties, its identifiers begin with `name`."""
    svg = _svg(figure)
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r'\b(id="|xlink:href="#|url\(#)', rf"\g<1>{name}-", svg)
    for colour, variable in ((INK, "ink"), (MUTED, "muted"), (FAINT, "faint"), (PAPER, "paper"), (ALARM, "bad")):
        svg = svg.replace(colour, f"var(--{variable})")
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    return svg.replace("<svg", f'<svg role="img" aria-label="{description}"', 1)


_LEAST_RANGE = 5.0  # of an axis, largest over least: points that are closer than that look it


def log_axes(axes: Axes) -> None:
    """Make axes of cost and error logarithmic: they span a least range, and ticks have unlike labels, errors in %."""
    axes.set(xscale="log", yscale="log")
    for axis, widen, text in ((axes.xaxis, axes.set_xlim, significant), (axes.yaxis, axes.set_ylim, percent)):
        low, high = axis.get_view_interval()
        if high < _LEAST_RANGE * low:
            middle = math.sqrt(low * high)
            low, high = middle / math.sqrt(_LEAST_RANGE), middle * math.sqrt(_LEAST_RANGE)
            widen(low, high)
        subdivisions = (1.0,) if high / low > 300.0 else (1.0, 3.0) if high / low > 30.0 else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=subdivisions, numticks=9))
        axis.set_major_formatter(FuncFormatter(lambda value, _, text=text: text(value, 1)))
        axis.set_minor_formatter(NullFormatter())


def note(axes: Axes, text: str, *, y: float = 0.5, colour: str = MUTED) -> None:
    """A remark in the middle of a panel that has nothing else to show."""
    axes.text(0.5, y, text, transform=axes.transAxes, ha="center", va="center", color=colour, wrap=True)
