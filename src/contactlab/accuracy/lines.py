"""Lines of convergence: the points of a case, a method and a slave over the levels, and costs of their targets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactlab.accuracy.point import NOT_RUN, Point
from contactlab.accuracy.run import Accuracy

CLEAR = 3.0
"""Times the uncertainty of a reference: errors below it say nothing, targets below it are grey."""
REPEATED = 3
"""Runs of a point from which on they tell the scatter. The median of further runs lies between the least and the
largest of n with a probability of 1 - 2^(1-n) only, three in four of 3: the scatter of all points says more."""
TINY = 1e-14


@dataclass(frozen=True)
class Line:
    """Points by increasing level.

    uncertainty  of the reference, as a fraction
    scatter      factor between median and ends of the interval, at least
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
    def lost(self) -> list[Point]:
        """The points that were begun and have no error, and the first one that was over its limit."""
        begun = [p for p in self.points if not p.finished and p.status not in NOT_RUN]
        return begun or [p for p in self.points if p.status == "over-limit"][:1]

    def lost_at(self, point: Point, limit: float) -> float:
        """Cost [s] at which a lost point is drawn: its limit where that stopped it, else what was spent until then."""
        if _kind(point.status) == "over-limit":
            return limit
        known = [p.cost for p in self.points if p.cost > 0.0 and p.level <= point.level]
        return known[-1] if known else limit

    @cached_property
    def errors(self) -> list[float]:
        """Return the largest error from each finished point on: a zero crossing is not a success."""
        found = np.array([max(point.error, TINY) for point in self.finished])
        return [float(e) for e in np.maximum.accumulate(found[::-1])[::-1]]

    def cheapest(self, error: float) -> Point | None:
        """The cheapest point that was run and whose error, like that of all finer ones, is not above `error`."""
        kept = [point for point, found in zip(self.finished, self.errors, strict=True) if found <= error]
        return min(kept, key=lambda point: point.cost, default=None)

    def interval(self, error: float) -> tuple[float, float]:
        """Least and largest cost [s] that repeated runs and the uncertainty of the reference leave."""
        sure = self.cheapest(error - self.uncertainty)
        kept = [p for p, found in zip(self.finished, self.errors, strict=True) if found <= error + self.uncertainty]
        low = min((self.times(point)[0] for point in kept), default=math.inf)
        return low, math.inf if sure is None else max(self.times(p)[1] for p in (sure, self.cheapest(error) or sure))

    def times(self, point: Point) -> tuple[float, float]:
        """Least and largest cost [s] of a point: of its repetitions, and at least the scatter of the study's."""
        return min(*point.cpu, point.cost / self.scatter), max(*point.cpu, point.cost * self.scatter)

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
    """Factor of their median that nine in ten of a study's repeated runs keep, medians themselves not counted.

    Without repetitions half of the range of the calibration beside the runs, in logarithms; inf where nothing tells.
    """
    times = [time / point.cost for point in points if point.cost > 0.0 and len(point.cpu) >= REPEATED
             for time in point.cpu if time > 0.0 and time != point.cost]  # fmt: skip
    if times:
        return float(np.exp(np.quantile(np.abs(np.log(times)), 0.9)))
    beside = [point.calibration for point in points if point.calibration > 0.0]
    return float(np.sqrt(np.divide(*np.quantile(beside, [0.9, 0.1])))) if len(beside) >= REPEATED else math.inf


def better(lines: Sequence[Line]) -> list[Line]:
    """Select the slave with the smaller error times cost for each method, and lines with a point of the front."""
    found: dict[str, Line] = {}
    for line in lines:
        before = found.get(line.contender)
        if line.finished and (before is None or _worth(line) < _worth(before)):
            found[line.contender] = line
    best = front(lines)
    return [line for line in lines if found.get(line.contender) is line or any(p in best for p in line.finished)]


def _worth(line: Line) -> float:
    return float(np.mean([math.log(max(p.error, TINY) * p.cost) for p in line.finished]))


def front(lines: Sequence[Line]) -> list[Point]:
    """The finished points of these lines that no other one beats in both error and cost, the cheapest first."""
    best = math.inf
    kept: list[Point] = []
    for point in sorted((p for line in lines for p in line.finished), key=lambda p: (p.cost, p.error)):
        if point.error < best:
            kept.append(point)
            best = point.error
    return kept
