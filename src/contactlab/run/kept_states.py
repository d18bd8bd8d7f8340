"""States that an explicit run keeps on its way, from which its steps come out again to the last bit."""

from __future__ import annotations

from collections import deque

import numpy as np

from contactlab.api import Floats
from contactlab.model.model import Model


class KeptState:
    """A copy of a state, and the length of the steps that followed it."""

    def __init__(self) -> None:
        self.fields: dict[str, Floats] = {}
        self.near: list[tuple[Floats, Floats] | None] = []
        self.step, self.dt = 0, 0.0

    def make_room(self, model: Model) -> None:
        """Have an array for each field of the state."""
        for name, field in model.state.fields.items():
            if name not in self.fields:
                self.fields[name] = np.empty_like(field)

    def take(self, model: Model, dt: float) -> None:
        """Copy the present state; into the same arrays every time. `dt` [s] is the length of the next step."""
        self.make_room(model)
        for name, field in model.state.fields.items():
            np.copyto(self.fields[name], field)
        pairs = model.contact.passes if model.contact is not None else ()
        self.near = [None if pair.near is None else (pair.near.slave, pair.near.master) for pair in pairs]
        self.step, self.dt = model.state.step, dt

    def bring_back(self, model: Model) -> None:
        """Bring state, positions and near lists back, in the model of the run or in another one of its scene.

        Constraints follow with the next step.
        """
        for name, field in self.fields.items():
            np.copyto(model.state[name], field)
        np.add(model.reference, model.state["displacement"], out=model.position)
        for forces in model.forces:
            forces.trial_history[:] = forces.history  # as they are after an accepted step
        for pair, near in zip(model.contact.passes if model.contact is not None else (), self.near, strict=True):
            if near is not None:
                pair.find_near(*near)

    def is_that_of(self, model: Model) -> bool:
        """Return whether a model is in this state, to the last bit."""
        return all(np.array_equal(model.state[name], field, equal_nan=True) for name, field in self.fields.items())


class KeptStates:
    """The last `most` states that were kept, the oldest first. There is room for all of them from the first one on."""

    def __init__(self, most: int = 1) -> None:
        self.spare = [KeptState() for _ in range(most)]
        self.states: deque[KeptState] = deque()

    def take(self, model: Model, dt: float) -> None:
        """Keep the present state, in the arrays of the oldest one when there are enough."""
        for unused in self.spare:
            unused.make_room(model)
        kept = self.spare.pop() if self.spare else self.states.popleft()
        kept.take(model, dt)
        self.states.append(kept)

    @property
    def newest(self) -> KeptState | None:
        """The state that was kept last; None if there is none."""
        return self.states[-1] if self.states else None
