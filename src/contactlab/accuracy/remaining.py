"""Errors left on the finest meshes of a scene: Richardson's rule with tried orders, and runs beside one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np


class Judged(Protocol):
    """Compares results of runs: pressures or forces."""

    what: str

    def value(self, pressures: Any, forces: Any) -> Any:
        """Return what is compared of a run; empty if it has none."""

    def sharpened(self, found: Any) -> Any:
        """The same without what no mesh follows."""

    def mean(self, all_of: Sequence[Any]) -> Any:
        """Mean of several runs."""

    def apart(self, found: Any, other: Any) -> float:
        """Relative distance."""


ORDERS = (0.5, 1.5)
"""Orders of convergence that are believed: edges of contact bound them at the one end, singular ones at the other."""
UNKNOWN = 0.75
"""Order that is taken while two levels are all there is."""
LEAST_ALIKE = 0.2
"""Correlation that changes from level to level are believed to have at least."""
ALONE = 1.5
"""Times the error that a single line of runs leaves by its own estimate: nothing stands beside it."""
NEAR_FINEST = 0.7
"""Level over the finest one from which on a run takes part in the reference."""


@dataclass(frozen=True)
class Ladder:
    """Results of one configuration by level; `cost` of its finest run [s]."""

    name: str
    family: tuple[Any, ...]
    values: Mapping[int, Any]
    cost: float

    @property
    def finest(self) -> int:
        """Its finest level."""
        return max(self.values)


@dataclass(frozen=True)
class Truth:
    """What runs are measured against.

    uncertainty  relative, of the value
    words        where both are from
    level        of its finest run
    alone        whether it is a single run
    """

    value: Any
    uncertainty: float
    words: str
    level: int
    alone: bool = False


def left_at(values: Mapping[int, Any], judged: Judged) -> float:
    """Relative error left at the finest of at least two levels, by Richardson's rule with the last three.

    Changes c1, c2 from level to level tell the order q of further ones, which fall as r = ratio^-q each. Whether they
    add up as numbers (a smooth error) or as squares (a local one, beside a corner or an edge) is told by the change
    over both levels: their correlation is k = (c^2 - c1^2 - c2^2) / (2 c1 c2), and what is left

        c2 ((1 - k) r^2 / (1 - r^2) + k r^2 / (1 - r)^2)^(1/2)
    """
    levels = sorted(values)[-3:]
    fine = [judged.sharpened(values[level]) for level in levels]
    change, order, alike = judged.apart(fine[-2], fine[-1]), UNKNOWN, 1.0
    if len(levels) == 3 and change > 0.0:
        before, both = judged.apart(fine[0], fine[1]), judged.apart(fine[0], fine[2])
        order = _order(np.array(levels, float), before, change)
        product = max(2.0 * before * change, 1e-300)
        alike = min(max((both**2 - before**2 - change**2) / product, LEAST_ALIKE), 1.0)
    fall = (levels[-2] / levels[-1]) ** order
    squares, numbers = fall**2 / (1.0 - fall**2), (fall / (1.0 - fall)) ** 2
    return float(change * np.sqrt((1.0 - alike) * squares + alike * numbers))


def _order(levels: Any, before: float, change: float) -> float:
    """The order among tried ones whose changes between three levels have this ratio."""
    tried = np.linspace(*ORDERS, 41)
    a, b, c = (level**-tried for level in levels)
    ratio = before / max(change, 1e-300)
    return float(tried[np.argmin(np.abs(np.log((a - b) / (b - c)) - np.log(max(ratio, 1e-300))))])


def ranked(ladders: Sequence[Ladder], judged: Judged) -> list[tuple[float, Ladder]]:
    """Ladders of at least two levels with the error that each has left, the least for its cost first."""
    found = [(left_at(each.values, judged), each) for each in ladders if len(each.values) > 1]
    return sorted(found, key=lambda pair: pair[0] * max(pair[1].cost, 1e-3) ** 0.4)


def beside(pairs: Sequence[tuple[float, Ladder]], most: int) -> list[tuple[float, Ladder]]:
    """The first of these, and further ones that differ from those before in algorithm or slave, or in element."""
    taken: list[tuple[float, Ladder]] = []
    for pair in pairs:
        if len(taken) < most and all(pair[1].family != other.family for _, other in taken):
            taken.append(pair)
    return taken


def truth_of(ladders: Sequence[Ladder], judged: Judged, climbers: int) -> Truth | None:
    """The mean of the best runs near the finest level; None if no ladder has two levels.

    Its uncertainty is the largest of the errors that they have left, of their distances from the mean, and of what
    the best runs with other elements or slaves lie off beyond twice their own errors.
    """
    pairs = sorted(ranked(ladders, judged), key=lambda pair: pair[0])
    if not pairs:
        return None
    best = beside(pairs, climbers)
    finest = max(ladder.finest for _, ladder in best)
    within = [pair for pair in best if pair[1].finest >= NEAR_FINEST * finest]
    values = [judged.sharpened(ladder.values[ladder.finest]) for _, ladder in within]
    mean = judged.mean(values)
    own = [left for left, _ in within]
    uncertainty = ALONE * own[0] if len(own) == 1 else float(np.mean(own))
    uncertainty = max(uncertainty, *(judged.apart(value, mean) for value in values))
    for left, ladder in best:
        off = judged.apart(judged.sharpened(ladder.values[ladder.finest]), mean)
        uncertainty = max(uncertainty, off - 2.0 * left)
    names = " and ".join(f"{ladder.name} at level {ladder.finest}" for _, ladder in within)
    return Truth(mean, float(uncertainty), names, finest, len(within) == 1)
