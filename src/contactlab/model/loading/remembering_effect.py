"""An effect with memory, bound to the state of a model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import Effect, Floats, State
from contactlab.errors import WrongAnswer
from contactlab.parts.remembered import remember


class RememberingEffect:
    """Adds forces that belong to memory and the time since; called as effects without memory are.

    rows  memory (N,) of each node by name, in the state
    """

    def __init__(self, effect: Effect, add: Callable[..., Any], state: State, field: str) -> None:
        self.effect, self.add, self.state = effect, add, state
        self.rows = dict(zip(effect.memory, state[field], strict=True))
        self.seen = {name: row.view() for name, row in self.rows.items()}
        for row in self.seen.values():
            row.flags.writeable = False
        self.spare = np.zeros_like(state["displacement"])
        remember(effect, "start", effect.start(), self.rows)

    def __call__(self, time: float, force: Floats) -> None:
        """Add the forces (N, 2) [N] at `time` [s]."""
        self.add(time, force, time - self.state.time, self.seen)

    def accept(self, time: float, dt: float) -> None:
        """A step of `dt` [s] that ends at `time` [s] is accepted, and has not moved the clock yet."""
        found = self.add(time, self.spare, dt, self.seen)
        if not isinstance(found, dict):
            kind = type(self.effect).__name__
            raise WrongAnswer(f"{kind}: the function of bind gave {type(found).__name__}, needed: a dict of memory")
        remember(self.effect, "the function of bind", {name: np.copy(row) for name, row in found.items()}, self.rows)
