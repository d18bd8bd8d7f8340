"""Start of the iteration of a load increment: with a history, bodies continue their motion of the step before.

At the start of a step the stiffness of a law with history is elastic. A correction by it loads contact many
times more than the step will, and most of the iterations are spent on constraints that it opened and closed wrongly.
Continued strains make the law flow from the first iteration on (de Souza Neto, Peric & Owen 2008, 4.4).
With friction contact finds its stick zones a little sooner. Without both, steps are long, and the motion of the
step before opens and closes more than it saves.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api import Floats, ImplicitEquations, State

FARTHEST = 4.0  # times the step before: no extrapolation beyond
ALONG = 0.9  # cosine between the motions of two steps, below which the loading turns


class Prediction:
    """Works on the state's displacement in place.

    moved    (N, 2) [mm] motion of the last step, kept in the state
    flows    True if a law has a history
    follows  True if steps continue the step before: bodies flow, or there is friction
    """

    def __init__(self, equations: ImplicitEquations, state: State) -> None:
        self.equations, self.state = equations, state
        self.moved = state["moved"]
        self.flows = any(name.startswith("history.") for name in state.fields)
        self.follows = self.flows or (equations.contact is not None and len(equations.contact.conditions.slip) > 0)
        self.load: Floats = np.zeros_like(self.moved)

    def start(self, dt: float, target: Floats, reachable: Callable[[Floats], bool] = lambda before: True) -> bool:
        """Extrapolate to the end of a step of length dt [s] with prescribed displacements `target` (p,) [mm].

        `reachable` returns whether the state may go there directly from a displacement (N, 2) [mm].

        Returns False if the state is unchanged: no flow, no step before, or loading that turns.
        """
        ratio = self._ratio(dt, target) if self.follows and self.state.last_dt else 0.0
        if not 0.0 < ratio <= FARTHEST:
            return False
        u = self.state["displacement"]
        before = u.copy()
        u += ratio * self.moved
        u.reshape(-1)[self.equations.prescribed.dof] = target
        if not reachable(before):
            u[:] = before
            return False
        self.equations.internal_force(dt)
        if self.equations.folded():
            u[:] = before
            return False
        return True

    def _ratio(self, dt: float, target: Floats) -> float:
        """Return the ratio of the step to the last step: by prescribed motion, or by loads if nothing is moved."""
        held = self.equations.prescribed.dof
        ahead = target - self.state["displacement"].reshape(-1)[held]
        ratio = _along(ahead, self.moved.reshape(-1)[held])
        if ratio is not None:
            return ratio
        now = self.state.time
        before, at, after = (self._load(time) for time in (now - self.state.last_dt, now, now + dt))
        return _along((after - at).ravel(), (at - before).ravel()) or 0.0

    def _load(self, time: float) -> Floats:
        self.load[:] = 0.0
        self.equations.external_force(time, self.load)
        return self.load.copy()


def _along(ahead: Floats, behind: Floats) -> float | None:
    """Return the ratio of `ahead` to `behind`; 0 if their directions differ, None without any."""
    size = float(behind @ behind)
    if size == 0.0:
        return None
    along = float(ahead @ behind)
    return along / size if along > ALONG * float(np.sqrt(size * (ahead @ ahead))) else 0.0
