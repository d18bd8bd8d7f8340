"""What a run of a mesh level will cost, from coarser ones: start + counted work x unit costs.

A line of two or three points cannot tell its unit costs from the scatter of CPU times. They are therefore shared by all
lines of a case that have the same kind of integrator (least squares of relative errors, none negative); a line has one
factor of its own, the geometric mean of measured over fitted cost. Only points from level 2 on count: imports of the
first calls and other fixed costs weigh too much before. Counts are time steps of explicit runs and iterations of
implicit ones. For each count there is work of the contact (in proportion to the square root of the number of nodes) and
of the cells (to the number of nodes). Implicit runs have factors of a plane mesh beside these (its power 3/2: George
1973), but once a load step: later iterations reuse them. Steps of explicit runs grow with the level, nodes as between
the two levels before; iterations are taken as the mean of these two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from contactlab.accuracy.lines import Line
from contactlab.accuracy.orders import FIRST
from contactlab.accuracy.point import Point
from contactlab.api.arrays import Floats

Group = tuple[str, bool]
"""Case, whether the runs are explicit."""


@dataclass(frozen=True)
class CostModel:
    """Unit costs [s] of each group, from points coarser than a level."""

    units: Mapping[Group, Floats]

    @classmethod
    def below(cls, level: int, lines: Sequence[Line]) -> CostModel:
        """Fit what the lines have below a level."""
        points: dict[Group, list[Point]] = {}
        for line in lines:
            points.setdefault(group_of(line), []).extend(coarser(line, level))
        return cls({group: _units(found, group[-1]) for group, found in points.items() if found})

    def cost(self, line: Line, level: int) -> float:
        """CPU time [s] of a level of a line that has two coarser points."""
        explicit = is_explicit(line)
        units, before = self.units[group_of(line)], coarser(line, level)
        fitted = np.array([float(_work(_counts(p, explicit), explicit) @ units) for p in before])
        factor = np.exp(np.mean(np.log(np.array([p.cost for p in before]) / fitted)))
        return float(factor * (_work(_next(before[-2:], level, explicit), explicit) @ units))


def coarser(line: Line, level: int) -> list[Point]:
    """The finished points of a line from level 2 on and below `level`."""
    return [point for point in line.finished if FIRST <= point.level < level]


def is_explicit(line: Line) -> bool:
    """Whether the runs of a line have no iterations."""
    return not any(point.counts.get("iterations") for point in line.finished)


def group_of(line: Line) -> Group:
    """The lines that share unit costs."""
    return line.case, is_explicit(line)


Counts = tuple[float, float, float]
"""Nodes, time steps or iterations, load steps."""


def _units(points: Sequence[Point], explicit: bool) -> Floats:
    work = np.array([_work(_counts(point, explicit), explicit) for point in points])
    return unit_costs(work, np.array([point.cost for point in points]))


def _work(counts: Counts, explicit: bool) -> Floats:
    """What each unit cost is multiplied by (3,), of implicit runs (4,)."""
    nodes, count, steps = counts
    shared = (1.0, count * nodes**0.5, count * nodes)
    return np.array(shared if explicit else (*shared, steps * nodes**1.5))


def _counts(point: Point, explicit: bool) -> Counts:
    steps = point.counts.get("steps") or 1.0
    count = steps if explicit else point.counts.get("iterations") or 1.0
    return point.counts.get("nodes") or float(point.level) ** 2, count, steps


def _next(before: Sequence[Point], level: int, explicit: bool) -> Counts:
    """What a level will count, from the two before it."""
    (first, one, _), (last, other, steps) = (_counts(point, explicit) for point in before)
    power = np.log(last / first) / np.log(before[1].level / before[0].level)
    ratio = level / before[1].level
    return last * ratio**power, other * ratio if explicit else (one * other) ** 0.5, steps


def unit_costs(work: Floats, cost: Floats, rest: Floats | None = None) -> Floats:
    """Prices (u,) >= 0 of u kinds of work from n runs with the `work` (n, u) and the `cost` (n,).

    `rest` (n,) is the part of the cost that these kinds of work explain; not given: all of it. Least squares of errors
    relative to the cost: a cheap run counts as much as a dear one (Lawson & Hanson 1974, ch. 23).
    """
    from scipy.optimize import nnls

    found: Floats = nnls(work / cost[:, None], np.ones(len(cost)) if rest is None else rest / cost)[0]
    return found
