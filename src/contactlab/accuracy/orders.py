"""Orders of convergence with their intervals, beside those that theory gives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactlab.accuracy.lines import CLEAR, TINY, Line
from contactlab.accuracy.run import Accuracy
from contactlab.api.arrays import Floats

FIRST = 2
"""Level from which orders are fitted, where three levels are left: the coarsest are before convergence begins."""


@dataclass(frozen=True)
class Order:
    """q of error ~ C h^q by least squares over `levels`, with the half-width of its 95 % interval; nan if unknown.

    theory  what the case says, nan where it says nothing
    """

    case: str
    contender: str
    slave: str
    order: float
    half: float
    levels: tuple[int, ...]
    theory: float


def orders_of(found: Accuracy, lines: Sequence[Line]) -> list[Order]:
    """Compute the order of each line with at least two points above the uncertainty of its reference."""
    theory = {asked.label: asked.order for asked in found.asked}
    return [order for line in lines if (order := _order(line, theory.get(line.case, math.nan))) is not None]


def _order(line: Line, theory: float) -> Order | None:
    clear = [(p.level, p.error) for p in line.finished if p.error > max(CLEAR * line.uncertainty, TINY)]
    late = [pair for pair in clear if pair[0] >= FIRST]
    used = late if len(late) >= 3 else clear
    if len(used) < 2:
        return None
    level, error = (np.array(values, float) for values in zip(*used, strict=True))
    order, half = slope(np.log(level), np.log(error))
    return Order(line.case, line.contender, line.slave, -order, half, tuple(int(v) for v in level), theory)


def slope(x: Floats, y: Floats) -> tuple[float, float]:
    """Slope of the least-squares line and the half-width of its 95 % interval, nan for two points."""
    away = x - x.mean()
    spread = float((away**2).sum())
    found, free = float((away * y).sum()) / spread, len(x) - 2
    if not free:
        return found, math.nan
    # with a second of libraries behind it: not before there are points
    from scipy.stats import t as student

    squares = float(((y - y.mean() - found * away) ** 2).sum())
    return found, float(student.ppf(0.975, free)) * math.sqrt(squares / free / spread)
