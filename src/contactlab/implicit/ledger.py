"""The energy ledger of implicit steps: works by the trapezoidal rule, exact for forces linear in displacement."""

from __future__ import annotations

import numpy as np

from contactlab.api import WORK, Floats, State

INTERNAL, EXTERNAL, CONTACT, FRICTION, SLIP = (
    WORK.index(name) for name in ("internal", "external", "contact", "friction", "slip")
)


class Ledger:
    """Books the work of every kind of force over a step."""

    def __init__(self, state: State) -> None:
        self.state = state
        self.before: list[Floats] = []

    def begin_step(self, external: Floats, normal: Floats, tangential: Floats) -> None:
        """Remember forces and positions at the start."""
        state = self.state
        self.displacement = state["displacement"].copy()
        self.before = [state[name].copy() for name in ("internal_force", "reaction")] + [
            external.copy(),
            normal.copy(),
            tangential.copy(),
        ]

    def end(self, external: Floats, normal: Floats, tangential: Floats, slip: float) -> None:
        """Book the step that led from there to the state as it is."""
        state, work = self.state, self.state["work"]
        moved = state["displacement"] - self.displacement
        internal, reaction, loads, pressed, rubbed = self.before
        work[INTERNAL] += _work(internal, state["internal_force"], moved)
        work[EXTERNAL] += _work(reaction, state["reaction"], moved) + _work(loads, external, moved)
        work[CONTACT] += _work(pressed, normal, moved)
        if len(tangential):
            work[FRICTION] += _work(rubbed, tangential, moved)
        work[SLIP] += slip


def _work(before: Floats, after: Floats, moved: Floats) -> float:
    return float(0.5 * np.vdot(before + after, moved))
