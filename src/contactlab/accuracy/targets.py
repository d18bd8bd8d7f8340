"""Cost of each target for each method in each case; the cheapest, and ties."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from contactlab.accuracy.lines import CLEAR, Line
from contactlab.accuracy.run import Accuracy

KINDS = ("reached", "not-reached", "over-limit", "not-run", "failed", "grey")
"""What can become of a target; the best first."""


@dataclass(frozen=True)
class Cost:
    """Return the cost at which a line comes below a target.

    kind       one of KINDS: grey are targets below what the reference can tell
    cost       CPU time of the cheapest run that keeps it [s], inf if none does; low, high  its interval
    level      of that run, 0 without one
    coarsest   the coarsest mesh is already that good: the cost is an upper bound
    why        in words, where it is not reached
    mark       "cheapest", "tied" or nothing
    """

    case: str
    contender: str
    slave: str
    target: float
    kind: str
    cost: float = math.inf
    low: float = math.inf
    high: float = math.inf
    level: int = 0
    coarsest: bool = False
    why: str = ""
    mark: str = ""


def costs_of(found: Accuracy, lines: Sequence[Line]) -> list[Cost]:
    """Every line at every target, with marks."""
    asked = {each.label: sorted(found.targets_of(each), reverse=True) for each in found.asked}
    costs = [_cost(line, target) for line in lines for target in asked[line.case]]
    groups: dict[tuple[str, float], list[Cost]] = {}
    for cost in costs:
        groups.setdefault((cost.case, cost.target), []).append(cost)
    marked = {id(cost): mark for group in groups.values() for cost, mark in _marks(group)}
    return [replace(cost, mark=marked.get(id(cost), "")) for cost in costs]


def _cost(line: Line, target: float) -> Cost:
    head = (line.case, line.contender, line.slave, target)
    if target < CLEAR * line.uncertainty:
        return Cost(*head, "grey", why=f"the reference is known to {100.0 * line.uncertainty:.2g} %")
    point = line.cheapest(target)
    if point is None:
        kind, why = line.ended(target)
        return Cost(*head, kind, why=why)
    coarsest = line.errors[0] <= target
    return Cost(*head, "reached", point.cost, *line.interval(target), point.level, coarsest)


def _marks(group: Sequence[Cost]) -> list[tuple[Cost, str]]:
    """The cheapest, and those whose intervals overlap with its own: then nobody is the cheapest, all of them tie."""
    there = [cost for cost in group if cost.kind == "reached"]
    if not there:
        return []
    best = min(there, key=lambda cost: cost.cost)
    tied = [cost for cost in there if cost is not best and cost.low <= best.high]
    # the other side of the same contender is no rival
    if all(cost.contender == best.contender for cost in tied):
        return [(best, "cheapest")]
    return [(cost, "tied") for cost in (best, *tied)]


def best_of(costs: Sequence[Cost]) -> dict[tuple[str, str, float], Cost]:
    """Select the better slave of each case, method and target."""
    found: dict[tuple[str, str, float], Cost] = {}
    for cost in costs:
        place = cost.case, cost.contender, cost.target
        before = found.get(place)
        if before is None or (KINDS.index(cost.kind), cost.cost) < (KINDS.index(before.kind), before.cost):
            found[place] = cost
    return found


def shown(cost: Cost | None) -> str:
    """A cost as tables write it."""
    if cost is None:
        return ""
    if cost.kind == "reached":
        text = f"{cost.cost:.2g}" if cost.cost < 100.0 else f"{cost.cost:.0f}"
        return ("\N{LESS-THAN OR EQUAL TO}" if cost.coarsest else "") + text
    return {"not-reached": "not reached", "over-limit": "over limit", "not-run": "not run",
            "failed": "failed", "grey": "\N{HORIZONTAL ELLIPSIS}"}[cost.kind]  # fmt: skip
