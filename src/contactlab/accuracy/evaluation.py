"""All that is worked out from the points of a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from contactlab.accuracy.lines import Line, lines_of
from contactlab.accuracy.orders import Order, orders_of
from contactlab.accuracy.run import Accuracy
from contactlab.accuracy.solved import Solved, solved
from contactlab.accuracy.targets import Cost, costs_of
from contactlab.accuracy.winners import Winner, winners_of


@dataclass(frozen=True)
class Evaluation:
    """A study with its lines of convergence, costs, winners, orders, shares answered in time."""

    found: Accuracy
    lines: Sequence[Line]
    costs: Sequence[Cost]
    winners: Sequence[Winner]
    orders: Sequence[Order]
    profiles: Sequence[Solved]


def evaluate(found: Accuracy) -> Evaluation:
    """Work everything out from the points."""
    lines = lines_of(found)
    costs = costs_of(found, lines)
    return Evaluation(found, lines, costs, winners_of(found, costs), orders_of(found, lines), solved(costs))
