"""Lines of a plot: runs that differ in level and slave alone, their labels and styles."""

from __future__ import annotations

from collections.abc import Sequence

from contactlab.api.drawing.colours import STYLES, Style, styles
from contactlab.studies.table import Row
from contactlab.studies.varied_text import varied_text

MARKERS = ("o", "s", "D", "^", "v", "P", "X", "*", "<", ">", "p", "h")


def series_of(row: Row, rows: Sequence[Row]) -> str:
    """Name of the line that a row belongs to among these rows."""
    text = varied_text(row.choices)
    several = len({each.algorithm for each in rows}) > 1
    return ", ".join(filter(None, [row.algorithm if several or not text else "", text]))


def series_styles(rows: Sequence[Row]) -> dict[str, Style]:
    """A style for each line: colours are algorithms, markers what else varies; of one algorithm both are the latter."""
    names = {series_of(row, rows): row for row in rows}
    own = styles(row.algorithm for row in rows)
    texts = list(dict.fromkeys(varied_text(row.choices) for row in rows))
    if texts == [""]:
        return {name: own[row.algorithm] for name, row in names.items()}
    found = {}
    for name, row in names.items():
        k = texts.index(varied_text(row.choices))
        colour = own[row.algorithm].colour if len(own) > 1 else STYLES[k % len(STYLES)].colour
        # past the last colour or marker the other one has moved on, so that pairs differ for 72 lines
        marker = MARKERS[k % len(MARKERS)] if len(own) > 1 else MARKERS[(k + k // len(STYLES)) % len(MARKERS)]
        found[name] = Style(colour, marker)
    return found
