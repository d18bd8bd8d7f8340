"""Performance profiles: the share of questions that a contender has answered within a time (Dolan & More 2002)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from contactlab.accuracy.targets import Cost

BEST = "virtual best"


@dataclass(frozen=True)
class Solved:
    """Costs [s] of the questions that a method solved, in increasing order, of `asked` in all.

    A question is a case, a slave and a target that the reference can tell; those that a contender cannot be put to
    are among those that it does not solve. `put` counts the ones that it can be put to.
    """

    contender: str
    times: tuple[float, ...]
    asked: int
    put: int

    def share(self, time: float) -> float:
        """Share of the questions solved within a time [s]; failures never count."""
        return sum(each <= time for each in self.times) / self.asked if self.asked else math.nan


def solved(costs: Sequence[Cost]) -> list[Solved]:
    """Every contender, and the virtual best of them last."""
    questions: dict[tuple[str, str, float], float] = {}
    found: dict[str, list[float]] = {}
    for cost in costs:
        if cost.kind == "grey":
            continue
        found.setdefault(cost.contender, []).append(cost.cost)
        place = cost.case, cost.slave, cost.target
        questions[place] = min(cost.cost, questions.get(place, math.inf))
    found[BEST] = list(questions.values())
    return [
        Solved(name, tuple(sorted(time for time in times if math.isfinite(time))), len(questions), len(times))
        for name, times in found.items()
    ]
