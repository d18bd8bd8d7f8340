"""The error of a mesh level, from coarser ones: C h^q from level 2 on, with an interval that holds nine of ten.

Two or three points of a line cannot tell its order from the scatter of errors (where the edge of contact lies in a
segment differs from mesh to mesh). The order is therefore that of the line's least squares, drawn to the median of all
lines of its case as by further points of spread OWN. The error goes on from the line's last point. The interval comes
from what such steps missed by, from each level to the next, in all lines of the study at the levels before: nine of ten
missed by less, where those of the case itself have half of the weight, as errors scatter more in some cases than in
others. Few steps may all be small by chance, and lines that differ in their enforcement alone repeat each other: steps
that missed by EDGE are among those of each case, as many as make little of a hundred. Only points above what the
reference can tell count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contactlab.accuracy.lines import CLEAR, TINY, Line
from contactlab.accuracy.orders import FIRST, LineFit, fitted_line
from contactlab.accuracy.point import Point

CHANCE = 0.9
"""With which the error lies in its interval."""
OWN = 0.3
"""Spread of log(level) [-] at which a line's own order counts as much as that of its case; levels 2, 4, 8 have 0.96."""
LEAST_STEPS = 5
"""Steps from level to level that a quantile is taken of, at least."""
UNKNOWN = 0.35
"""Logarithm of an error over its prediction that is expected where there are fewer: it is that of the bundled study."""
EDGE = 0.5
"""What a step misses by that says nothing of its own: pressed deeper by an eighth of a segment at a time, errors of one
mesh lie within factors of 2.2 (P0) to 3 (P1) of each other (docs/accuracy.md), and half of their logarithms are 0.4 and
0.55."""
EDGES = 10
"""Such steps beside those of a case. With 5 to 50, 83 to 86 % of errors of the bundled study lie in their intervals."""


@dataclass(frozen=True)
class Step:
    """From one level of a line of a case to the next: how far the case's order missed, and over which ratio of levels.

    miss   absolute logarithm of measured over predicted error
    ratio  logarithm of the ratio of levels
    """

    case: str
    miss: float
    ratio: float


@dataclass(frozen=True)
class ErrorModel:
    """Orders of the cases, and the steps from level to level, from points coarser than a level."""

    orders: Mapping[str, float]
    steps: Sequence[Step]

    @classmethod
    def below(cls, level: int, lines: Sequence[Line]) -> ErrorModel:
        """Learn from what the lines have below a level."""
        own: dict[str, list[float]] = {}
        for line in lines:
            points = clear(line, level)
            if len(points) > 1:
                own.setdefault(line.case, []).append(-_fit(points).slope)
        orders = {case: float(np.median(found)) for case, found in own.items()}
        return cls(orders, [step for line in lines for step in _steps(line, level, orders)])

    def error(self, line: Line, level: int) -> tuple[float, float, float] | None:
        """The error at a level and the ends of its interval; None from fewer than two points."""
        points = clear(line, level)
        if len(points) < 2:
            return None
        fit = _fit(points)
        order = (-fit.slope * fit.spread + self.orders[line.case] * OWN) / (fit.spread + OWN)
        away = math.log(level / points[-1].level)
        middle = math.log(points[-1].error) - order * away
        half = self.missed(line.case) * max(1.0, away / max(step.ratio for step in self.steps))
        return math.exp(middle), max(math.exp(middle - half), TINY), math.exp(middle + half)

    def missed(self, case: str) -> float:
        """What nine of ten steps missed by at most, those of the case and all others with half of the weight each."""
        if len(self.steps) < LEAST_STEPS:
            return UNKNOWN
        own = [step.miss for step in self.steps if step.case == case] + [EDGE] * EDGES
        others = [step.miss for step in self.steps if step.case != case]
        miss = np.array(own + others)
        weight = np.repeat([1.0 / len(own), 1.0 / max(len(others), 1)], [len(own), len(others)])
        order = np.argsort(miss)
        share = np.cumsum(weight[order])
        return float(miss[order][np.searchsorted(share, CHANCE * share[-1] - TINY)])


def clear(line: Line, level: int) -> list[Point]:
    """The points from level 2 on and below `level` whose error the reference can tell."""
    least = max(CLEAR * line.uncertainty, TINY)
    return [point for point in line.finished if FIRST <= point.level < level and point.error > least]


def _fit(points: Sequence[Point]) -> LineFit:
    return fitted_line(np.log([p.level for p in points]), np.log([p.error for p in points]))


def _steps(line: Line, level: int, orders: Mapping[str, float]) -> Iterator[Step]:
    points = clear(line, level)
    for coarse, fine in pairwise(points):
        ratio = math.log(fine.level / coarse.level)
        yield Step(line.case, abs(math.log(fine.error / coarse.error) + orders[line.case] * ratio), ratio)
