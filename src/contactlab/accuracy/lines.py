"""Lines of convergence: the points of a case, a contender and a slave over the levels, and costs read from them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy

CLEAR = 3.0
"""Times the uncertainty of a reference: errors below it say nothing, targets below it are grey."""
BEYOND = 1.5
"""How far in error a line is followed past its last point, to say how wide an interval is."""
LEAST_SCATTER = 1.12
"""Factor that the cost of a single run may be off either way: the same study twice, on a machine with other work, gave
costs of short runs that differed by up to 1.24."""
TINY = 1e-14


@dataclass(frozen=True)
class Line:
    """Points by increasing level.

    uncertainty  of the reference, as a fraction
    scatter      factor by which the cost of a single run may be off either way
    """

    case: str
    contender: str
    slave: str
    points: Sequence[Point]
    uncertainty: float
    scatter: float

    @property
    def name(self) -> str:
        """Contender, and the slave where it is not the declared one."""
        return self.contender + (", exchanged" if self.slave == "exchanged" else "")

    @cached_property
    def finished(self) -> list[Point]:
        """The points that have an error and a cost."""
        return [point for point in self.points if point.finished and point.cost > 0.0]

    @cached_property
    def errors(self) -> list[float]:
        """Of each finished point the largest error from there on: one that crosses zero on its way is no luck."""
        found = np.array([max(point.error, TINY) for point in self.finished])
        return [float(e) for e in np.maximum.accumulate(found[::-1])[::-1]]

    def cost_at(self, error: float) -> float:
        """CPU time [s] from which on the error stays below `error`, between points log-log; inf where none is."""
        costs = [point.cost for point in self.finished]
        return _cost_at(costs, self.errors, error)

    def interval(self, error: float) -> tuple[float, float]:
        """Least and largest cost [s] that the scatter of times and the uncertainty of the reference leave."""
        low = self.cost_at(error + self.uncertainty)
        high = self.cost_at(error - self.uncertainty) if error > self.uncertainty else math.inf
        spread = self.spread
        return low / spread, high * spread

    @cached_property
    def spread(self) -> float:
        """Factor of the costs either way: as repetitions differ, else as the calibration beside single runs does."""
        ratios = [max(max(p.cpu) / p.cost, p.cost / max(min(p.cpu), TINY)) for p in self.finished if len(p.cpu) > 2]
        return max(ratios) if ratios else self.scatter

    def ended(self, error: float) -> tuple[str, str]:
        """Why it does not come below `error`: a kind, and words."""
        if not self.finished:
            first = next((p for p in self.points if p.status != "finished"), None)
            return (_kind(first.status), f"{first.status}: {first.reason}") if first else ("not-run", "not run")
        finest = self.finished[-1]
        later = [p for p in self.points if p.level > finest.level]
        best = f"{100.0 * self.errors[-1]:.2g} % at level {finest.level}"
        if not later:
            return "not-reached", f"not reached: {best}"
        return _kind(later[0].status), f"{best}; level {later[0].level} {later[0].status}: {later[0].reason}"


def _kind(status: str) -> str:
    if status in ("over-limit", "timed-out"):
        return "over-limit"
    return "not-run" if status in ("over-budget", "interrupted", "waiting", "not-applicable") else "failed"


def _cost_at(costs: Sequence[float], errors: Sequence[float], error: float) -> float:
    """Where a falling line goes through `error`: on its segments, and a little past its end where it still falls."""
    if not errors:
        return math.inf
    if errors[0] <= error:
        return costs[0]
    for k in range(1, len(errors)):
        if errors[k] <= error:
            return _between(costs[k - 1 : k + 1], errors[k - 1 : k + 1], error)
    if len(errors) > 1 and errors[-1] <= BEYOND * error and errors[-1] < errors[-2] and costs[-1] > costs[-2]:
        return _between(costs[-2:], errors[-2:], error)
    return math.inf


def _between(costs: Sequence[float], errors: Sequence[float], error: float) -> float:
    share = math.log(errors[0] / error) / math.log(errors[0] / errors[1])
    return float(costs[0] * (costs[1] / costs[0]) ** share)


def reached(line: Line, target: float) -> bool:
    """Whether a run of the line has come below the target, and every finer one that finished, too."""
    return bool(line.errors) and min(line.errors) <= target


def lines_of(found: Accuracy) -> list[Line]:
    """All lines, in the order of the study."""
    scatter = scatter_of(found.points)
    known = {asked.label: asked.uncertainty for asked in found.asked}
    groups: dict[tuple[str, str, str], list[Point]] = {}
    for point in found.points:
        groups.setdefault((point.case, point.contender, point.slave), []).append(point)
    return [
        Line(*name, sorted(points, key=lambda p: p.level), known.get(name[0], 0.0), scatter)
        for name, points in groups.items()
    ]


def scatter_of(points: Sequence[Point]) -> float:
    """Factor that CPU times of equal work differ by either way: half of the range of the calibration, in logarithms."""
    times = [point.calibration for point in points if point.calibration > 0.0]
    if len(times) < 5:
        return 1.2  # a machine that nobody has watched; found on shared ones
    low, high = np.quantile(times, [0.1, 0.9])
    return float(max(LEAST_SCATTER, np.sqrt(high / low)))


def front(lines: Sequence[Line]) -> list[Point]:
    """The finished points of these lines that no other one beats in both error and cost, the cheapest first."""
    best = math.inf
    kept: list[Point] = []
    for point in sorted(_points(lines), key=lambda p: (p.cost, p.error)):
        if point.error < best:
            kept.append(point)
            best = point.error
    return kept


def _points(lines: Sequence[Line]) -> Iterator[Point]:
    for line in lines:
        yield from line.finished
