"""Cost and error of the finest point of each line, predicted from coarser meshes, beside what was measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from contactlab.accuracy.cost_model import CostModel, coarser
from contactlab.accuracy.error_model import ErrorModel
from contactlab.accuracy.lines import CLEAR, Line
from contactlab.accuracy.orders import FIRST

LEAST = 2
"""Points from level 2 on that a prediction is made from, at least."""
COST_OFF = 0.4
"""A predicted cost that is further off, as a fraction of the measured one, is a misprediction."""
WIDE = 3.0
"""High over low end of an interval that is too wide to be of use."""


@dataclass(frozen=True)
class Prediction:
    """The finest point of a line as coarser ones predict it, and as it came; nan where there is nothing to tell.

    levels     of the line's own points below it
    cost       measured, predicted_cost: predicted [s]
    error      measured, predicted_error: predicted, as fractions; low, high: its interval
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
        """Whether an error was predicted."""
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
    """The finest finished point of every line that has enough before it, from no point as fine as that."""
    late = [line for line in lines if sum(point.level >= FIRST for point in line.finished) > LEAST]
    finest = {line.finished[-1].level for line in late}
    costs = {level: CostModel.below(level, lines) for level in finest}
    errors = {level: ErrorModel.below(level, lines) for level in finest}
    return [_prediction(line, costs[level], errors[level]) for line in late for level in (line.finished[-1].level,)]


def _prediction(line: Line, costs: CostModel, errors: ErrorModel) -> Prediction:
    last = line.finished[-1]
    told = errors.error(line, last.level) if last.error > CLEAR * line.uncertainty else None
    error, low, high = told or (math.nan, math.nan, math.nan)
    levels = tuple(point.level for point in coarser(line, last.level))
    return Prediction(
        line.case, line.contender, line.slave, last.level, levels, last.cost, costs.cost(line, last.level), last.error,
        error, low, high,
    )  # fmt: skip
