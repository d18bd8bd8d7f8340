"""All contact pairs of a model under a normal law, for implicit integrators."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, State
from contactlab.contact.implicit_system import ImplicitContactSystem
from contactlab.contact.pair import ContactPair
from contactlab.contact.pressure_response import PressureResponse, PressureStore


class ImplicitPressureSystem(ImplicitContactSystem):
    """`ImplicitContactSystem` whose surfaces store the energy of `store`, with its law's memory."""

    def __init__(
        self,
        pairs: tuple[ContactPair, ...],
        response: PressureResponse,
        store: PressureStore,
        state: State,
        time: Floats,
    ) -> None:
        super().__init__(pairs, response, state, time, consistent=False)
        self.store = store

    @property
    def stored_since_start(self) -> float:
        """Energy [mJ] stored in surfaces beyond their energy at the start."""
        return self.store.since_start()

    def begin_step(self, position: Floats, time: float) -> None:
        """Begin a step as every system, and of the law's memory."""
        if self.store.memory is not None:
            self.store.memory.begin_step(time, time - self.state.time)
        super().begin_step(position, time)

    def _release(self, time: float) -> None:
        super()._release(time)
        if self.store.follows_steps:
            self._evaluate_start(time)
            self.store.start[:] = np.where(self.conditions.present, self.conditions.gap, np.inf)

    def accept(self) -> None:
        """Move the memory of the last evaluation, and of the law, into the state."""
        self.store.accept(self.conditions)
        super().accept()
