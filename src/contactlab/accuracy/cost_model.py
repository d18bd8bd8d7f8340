"""What a run of a mesh level will cost, from coarser ones: start + counted work x unit costs.

A line of two or three points cannot tell its unit costs from the scatter of CPU times. They are therefore shared by all
lines of a case that have the same contact algorithm and kind of integrator, since these do the same work on the same
meshes (least squares of relative errors, none negative); a line has one factor of its own, the geometric mean of
measured over fitted cost. Counts are time steps of explicit runs and iterations of implicit ones. For each count there
is work of the contact (in proportion to the level), of the cells (its square), and of implicit runs for factors of a
plane mesh (its cube: George 1973). Steps of explicit runs grow with the level; iterations are taken as the mean of the
two levels before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from contactlab.accuracy.lines import Line
from contactlab.accuracy.point import Point
from contactlab.api.arrays import Floats

Group = tuple[str, str, bool]
"""Case, contact algorithm, whether the runs are explicit."""


@dataclass(frozen=True)
class CostModel:
    """Unit costs [s] of each group, from points coarser than a level."""

    units: Mapping[Group, Floats]

    @classmethod
    def below(cls, level: int, lines: Sequence[Line]) -> CostModel:
        """Fit what the lines have below a level."""
        points: dict[Group, list[Point]] = {}
        for line in lines:
            coarse = coarser(line, level)
            if coarse:
                points.setdefault(group_of(line), []).extend(coarse)
        return cls({group: _units(found, group[-1]) for group, found in points.items()})

    def cost(self, line: Line, level: int) -> float:
        """CPU time [s] of a level of a line that has coarser points."""
        explicit = is_explicit(line)
        units, before = self.units[group_of(line)], coarser(line, level)
        fitted = np.array([float(_work(p.level, _count(p, explicit), explicit) @ units) for p in before])
        factor = np.exp(np.mean(np.log(np.array([p.cost for p in before]) / fitted)))
        return float(factor * (_work(level, _next_count(before, level, explicit), explicit) @ units))


def coarser(line: Line, level: int) -> list[Point]:
    """The finished points of a line below a level."""
    return [point for point in line.finished if point.level < level]


def is_explicit(line: Line) -> bool:
    """Whether the runs of a line have no iterations."""
    return not any(point.counts.get("iterations") for point in line.finished)


def group_of(line: Line) -> Group:
    """The lines that share unit costs."""
    return line.case, line.contender.partition(" ")[0], is_explicit(line)


def _units(points: Sequence[Point], explicit: bool) -> Floats:
    work = np.array([_work(p.level, _count(p, explicit), explicit) / p.cost for p in points])
    units: Floats = nnls(work, np.ones(len(points)))[0]
    return units


def _work(level: int, count: float, explicit: bool) -> Floats:
    """What each unit cost is multiplied by (3,), of implicit runs (4,)."""
    powers = (1, 2) if explicit else (1, 2, 3)
    return np.array([1.0, *(count * float(level) ** power for power in powers)])


def _count(point: Point, explicit: bool) -> float:
    return point.counts.get("steps" if explicit else "iterations", 1.0) or 1.0


def _next_count(before: Sequence[Point], level: int, explicit: bool) -> float:
    counts = [_count(point, explicit) for point in before[-2:]]
    if explicit:
        return counts[-1] * level / before[-1].level
    return float(np.exp(np.mean(np.log(counts))))
