"""How near pressures come to the best that their nodes allow, as a section of the page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from contactlab.accuracy.lines import Line
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy
from contactlab.reports.html import plain_table, section

_TEXT = (
    "<p>Efficiency: the error (in L2) of the best approximation of the exact pressure on the same slave nodes over "
    "the error of the run, at its finest level; with the better slave. At 1 no algorithm could do better on this mesh, "
    "at 0.5 one with half of the error is possible. Pressures are compared as continuous piecewise linear functions, "
    "those of constant multipliers and of nodal forces, too. In brackets the level.</p>"
)


def finest_efficiencies(lines: Sequence[Line]) -> dict[tuple[str, str], Point]:
    """Of each case and contender the finest point that has an efficiency, of the slave that has the better one."""
    found: dict[tuple[str, str], Point] = {}
    for line in lines:
        point = next((p for p in reversed(line.finished) if not math.isnan(p.efficiency)), None)
        place = line.case, line.contender
        if point is not None and (place not in found or _rank(point) > _rank(found[place])):
            found[place] = point
    return found


def _rank(point: Point) -> tuple[int, float]:
    return point.level, point.efficiency


def efficiency_rows(found: Accuracy, points: Mapping[tuple[str, str], Point]) -> list[list[str]]:
    """A row per contender that has one, a column per case; the cases first."""
    cases = [asked.label for asked in found.asked if any(case == asked.label for case, _ in points)]
    rows = [["contender", *cases]]
    for name in found.contenders:
        cells = [points.get((case, name)) for case in cases]
        if any(cells):
            rows.append([name, *(f"{p.efficiency:.2f} ({p.level})" if p else "" for p in cells)])
    return rows


def limits_section(found: Accuracy, lines: Sequence[Line]) -> str:
    """The table; empty where no case has an exact pressure."""
    points = finest_efficiencies(lines)
    if not points:
        return ""
    heads, *rows = efficiency_rows(found, points)
    return section("How near to the limit", _TEXT + plain_table(heads, rows, texts=1))
