"""Cost and error of a mesh level, predicted from the levels before it.

cost   start + unit costs x counted work, the unit costs by least squares of relative errors, none negative. Work of an
       explicit run: steps x cells. Of an implicit one: iterations x cells, and iterations x cells^1.5, what factors of
       a plane mesh take (George 1973). Counts of steps and iterations go on as a power of the level.
error  C h^q by least squares of logarithms, with an interval that holds the next point with a chance of 90 %; how much
       points scatter about such lines is learnt from all lines of the study, since one line has few points.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.stats import t as student

from contactlab.accuracy.line_fit import LineFit, fitted_line
from contactlab.accuracy.lines import CLEAR, TINY, Line
from contactlab.accuracy.orders import FIRST
from contactlab.accuracy.point import Point

LEAST = 2
"""Points that a prediction is made from, at least."""
CHANCE = 0.9
"""With which the error lies in its interval."""
COST_OFF = 0.4
"""A predicted cost that is further off, as a fraction of the measured one, is a misprediction."""
WIDE = 3.0
"""High over low end of an interval that is too wide to be of use."""
LEARNT = 4.0
"""Degrees of freedom that the scatter of all lines counts as, beside a line's own."""
UNKNOWN_SCATTER = 0.15
"""Standard deviation of logarithms of errors about their line, where no line has points to spare."""


@dataclass(frozen=True)
class Prediction:
    """The finest point of a line as the others foretell it, and as it came; nan where there is nothing to tell.

    levels     those that it was made from
    cost       measured, predicted_cost: foretold [s]
    error      measured, predicted_error: foretold, as fractions; low, high: its interval
    """

    case: str
    contender: str
    slave: str
    level: int
    levels: tuple[int, ...]
    cost: float
    predicted_cost: float
    error: float
    predicted_error: float
    low: float
    high: float

    @property
    def cost_off(self) -> float:
        """Predicted over measured cost, less one."""
        return self.predicted_cost / self.cost - 1.0

    @property
    def tells_error(self) -> bool:
        """Whether an error was foretold."""
        return math.isfinite(self.predicted_error)

    @property
    def is_within(self) -> bool:
        """Whether the error lies in its interval."""
        return self.low <= self.error <= self.high

    @property
    def is_wide(self) -> bool:
        """Whether the interval is too wide to be of use."""
        return self.high > WIDE * self.low

    @property
    def is_off(self) -> bool:
        """Whether it missed: the cost, or the error."""
        return abs(self.cost_off) > COST_OFF or (self.tells_error and not self.is_within)


def predictions_of(lines: Sequence[Line]) -> list[Prediction]:
    """The finest finished point of every line that has enough before it."""
    late = [(line, [point for point in line.finished if point.level >= FIRST]) for line in lines]
    asked = [(line, points[:-1], points[-1]) for line, points in late if len(points) > LEAST]
    fits = [_error_fit(line, before) for line, before, _ in asked]
    variance = _scatter([fit for fit in fits if fit is not None])
    return [_prediction(*each, fit, variance) for each, fit in zip(asked, fits, strict=True)]


def _prediction(line: Line, before: list[Point], last: Point, fit: LineFit | None, variance: float) -> Prediction:
    error = low = high = math.nan
    if fit is not None and last.error > CLEAR * line.uncertainty:
        error, low, high = _foretold(fit, last.level, variance)
        low, high = max(low - line.uncertainty, TINY), high + line.uncertainty
    return Prediction(
        line.case, line.contender, line.slave, last.level, tuple(point.level for point in before),
        last.cost, predicted_cost(before, last.level), last.error, error, low, high,
    )  # fmt: skip


def predicted_cost(before: Sequence[Point], level: int) -> float:
    """CPU time [s] of a level from points (at least two) of coarser ones."""
    levels = np.array([point.level for point in before], float)
    costs = np.array([point.cost for point in before])
    explicit = not any(point.counts.get("iterations") for point in before)
    counts = np.array([point.counts.get("steps" if explicit else "iterations", 1.0) or 1.0 for point in before])
    growth = float(np.clip(np.polyfit(np.log(levels), np.log(counts), 1)[0], 0.0, 2.0))
    count = counts[-1] * (level / levels[-1]) ** growth
    work = _work(levels, counts, explicit)
    unit, _ = nnls(work / costs[:, None], np.ones(len(costs)))
    return float((_work(np.array([float(level)]), np.array([count]), explicit) @ unit)[0])


def _work(levels: np.ndarray, counts: np.ndarray, explicit: bool) -> np.ndarray:
    """Columns that unit costs belong to; cells grow with the square of the level."""
    columns = [np.ones(len(levels)), counts * levels**2]
    return np.stack(columns if explicit else [*columns, counts * levels**3], axis=1)


def _error_fit(line: Line, before: Sequence[Point]) -> LineFit | None:
    """Logarithms of errors over those of levels, where enough are above what the reference can tell."""
    clear = [point for point in before if point.error > max(CLEAR * line.uncertainty, TINY)]
    if len(clear) < LEAST:
        return None
    return fitted_line(np.log([point.level for point in clear]), np.log([point.error for point in clear]))


def _scatter(fits: Sequence[LineFit]) -> float:
    """Variance of logarithms of errors about their lines, over all that have points to spare."""
    free = sum(fit.free for fit in fits)
    return sum(fit.squares for fit in fits) / free if free else UNKNOWN_SCATTER**2


def _foretold(fit: LineFit, level: int, variance: float) -> tuple[float, float, float]:
    """Error at a level, and the ends of its interval."""
    away = math.log(level) - fit.middle
    free = LEARNT + fit.free
    scatter = (LEARNT * variance + fit.squares) / free
    deviation = math.sqrt(scatter * (1.0 + 1.0 / fit.count + away**2 / fit.spread))
    half = float(student.ppf(0.5 + CHANCE / 2.0, free)) * deviation
    middle = fit.mean + fit.slope * away
    return math.exp(middle), math.exp(middle - half), math.exp(middle + half)
