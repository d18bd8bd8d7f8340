"""Who wins where: of each case and target the cheapest method, or the group that cannot be told apart, and the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from contactlab.accuracy.run import Accuracy
from contactlab.accuracy.targets import Cost, best_of, shown


@dataclass(frozen=True)
class Winner:
    """The answer of one case at one target.

    kind     reached; else the best that became of it (targets.KINDS)
    first    the cheapest method; group  all that tie with it, itself first
    cost     of the first one [s], low, high  its interval; level  of its mesh; coarsest  whether no coarser one was run
    next     the cheapest method outside of the group, factor  its cost over that of the first one
    """

    case: str
    target: float
    kind: str
    group: tuple[str, ...] = ()
    slave: str = ""
    level: int = 0
    cost: float = math.inf
    low: float = math.inf
    high: float = math.inf
    coarsest: bool = False
    next: str = ""
    factor: float = math.nan

    @property
    def first(self) -> str:
        """The cheapest method, nothing where no one reached the target."""
        return self.group[0] if self.group else ""


def winners_of(found: Accuracy, costs: Sequence[Cost]) -> list[Winner]:
    """A winner per case and target that was asked, in the order of the study."""
    best: dict[tuple[str, float], list[Cost]] = {}
    for (case, _, target), cost in best_of(costs).items():
        best.setdefault((case, target), []).append(cost)
    return [
        _winner(asked.label, target, best[asked.label, target])
        for asked in found.asked
        for target in sorted(found.targets_of(asked), reverse=True)
        if (asked.label, target) in best
    ]


def _winner(case: str, target: float, costs: Sequence[Cost]) -> Winner:
    there = sorted((cost for cost in costs if cost.kind == "reached"), key=lambda cost: cost.cost)
    if not there:
        kinds = [cost.kind for cost in costs]
        return Winner(case, target, "grey" if "grey" in kinds else max(kinds, key=kinds.count))
    first = there[0]
    group = [cost for cost in there if cost is first or cost.mark == "tied"]
    others = [cost for cost in there if cost not in group]
    after = (others[0].contender, others[0].cost / first.cost) if others else ("", math.nan)
    return Winner(
        case, target, "reached", tuple(cost.contender for cost in group), first.slave, first.level, first.cost,
        first.low, first.high, first.coarsest, *after,
    )  # fmt: skip


def grouped(names: Sequence[str]) -> str:
    """Names of methods with common element and way once: "mortar-p0, mortar-p1 q1 statics; gauss-point q2 statics"."""
    ways: dict[str, list[str]] = {}
    for name in names:
        algorithm, _, way = name.partition(" ")
        ways.setdefault(way, []).append(algorithm)
    return "; ".join(f"{', '.join(algorithms)} {way}".strip() for way, algorithms in ways.items())


def told(winner: Winner) -> tuple[str, str, str]:
    """Words of a cell: who wins, at what cost, and by how much the next is dearer."""
    if not winner.group:
        return shown(Cost(winner.case, "", "", winner.target, winner.kind)), "", ""
    bound = "\N{LESS-THAN OR EQUAL TO} " if winner.coarsest else ""
    after = f"next \N{MULTIPLICATION SIGN}{winner.factor:.2g}: {winner.next}" if winner.next else "no other keeps it"
    tie = "" if len(winner.group) == 1 else f"{len(winner.group)} tie: "
    return f"{tie}{grouped(winner.group)}", f"{bound}{winner.cost:.2g} s, level {winner.level}", after
