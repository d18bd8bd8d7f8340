"""States after Newton's iterations, copied during a run: displacements and gaps, as far as the budget allows."""

from __future__ import annotations

import numpy as np

from contactlab.api.frame import Iterate
from contactlab.model.implicit_model import ImplicitModel
from contactlab.results.precision import placed
from contactlab.results.record_plan import IteratePlan

PLACES = 20
"""Bits of displacements, of the largest: iterations that converge differ little."""


class IterateSampler:
    """Copies what `plan` keeps of the iterations of a run, from number `done` + 1 on.

    first, last  steps whose iterations are looked at: `record.from` and `record.to`
    """

    def __init__(self, model: ImplicitModel, plan: IteratePlan, first: int, last: float, done: int) -> None:
        self.model, self.plan, self.first, self.last = model, plan, first, last
        self.number = done
        self.due = plan.following(done)
        self.waiting: list[Iterate] = []
        self.told = done > plan.sure

    def seen(self) -> None:
        """An iteration has ended."""
        self.number += 1
        if self.number < self.due:
            return
        self.due = self.plan.following(self.number)
        if self.first <= self.model.state.step + 1 <= self.last:
            moved = placed(self.model.state["displacement"], PLACES)
            self.waiting.append(Iterate(self.number, moved, _gaps(self.model)))

    def take(self, iterations: int) -> list[Iterate]:
        """Return states of an attempted step; none if its integrator reported other iterations than it made."""
        some, self.waiting = self.waiting, []
        if self.number == iterations:
            return some
        self.number, self.due = iterations, self.plan.following(iterations)
        return []

    def thinned(self) -> str:
        """Return a message when iterations are left out for the first time; else empty."""
        if self.told or self.number <= self.plan.sure:
            return ""
        self.told = True
        return (
            f"from iteration {self.plan.sure} on displacements of some iterations are left out, as they exceed "
            "record.budget; choose a window by record.from and record.to"
        )


def _gaps(model: ImplicitModel) -> np.ndarray:
    if model.contact is None:
        return np.zeros(0, np.float32)
    conditions = model.contact.conditions
    return np.where(conditions.present, conditions.gap, np.nan)[: model.shown_conditions].astype(np.float32)
