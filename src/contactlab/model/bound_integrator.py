"""An integrator at work: the core keeps its clock, energy balance and reactions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from contactlab.api import Floats, State, Step, StepStatus
from contactlab.errors import SimulationFailure, WrongAnswer


class BoundIntegrator:
    """Makes steps of `state`, and stores their energy balance, reactions and time.

    name     of the integrator, for messages
    advance  result of its `bind`
    follow   functions called with the end and the length [s] of each accepted step
    """

    def __init__(
        self,
        name: str,
        advance: Callable[[float], Step],
        state: State,
        follow: tuple[Callable[[float, float], None], ...] = (),
    ) -> None:
        self.name, self.advance, self.follow = name, advance, follow
        self.clock, self.work, self.reaction = state["clock"], state["work"], state["reaction"]
        self.error = state["step_error"] if "step_error" in state else None

    def step(self, dt: float) -> Step:
        """Make one step of length dt [s], and check its result.

        Raises WrongAnswer if the integrator breaks the contract, and SimulationFailure if the clock would
        stand, so that a run never ends.
        """
        clock = self.clock
        time, count = float(clock[0]), float(clock[1])
        after = time + dt
        if not time < after < math.inf:
            _refuse_step(count, time, dt)
        done = self.advance(dt)
        if type(done) is not Step:
            raise WrongAnswer(f"{self.name}: its step gave {type(done).__name__}, needed: Step")
        if clock[0] != time or clock[1] != count:
            raise WrongAnswer(f"{self.name}: its step wrote the clock, which is the core's; needed: leave it alone")
        if done.status is StepStatus.accepted:
            # an integrator that books in place needs no copy
            if done.work is not self.work:
                self._store("work", done.work, self.work)
            if done.reaction is not self.reaction:
                self._store("reaction", done.reaction, self.reaction)
            if self.error is not None:
                if done.error is None or not done.error >= 0.0:
                    raise WrongAnswer(f"{self.name}: its step gave error {done.error}, needed: a number of at least 0")
                self.error[1], self.error[0] = self.error[0], done.error
            for remember in self.follow:
                remember(after, dt)
            clock[0], clock[1], clock[2] = after, count + 1.0, dt
        return done

    def _store(self, name: str, given: Floats | None, field: Floats) -> None:
        if given is None:
            raise WrongAnswer(f"{self.name}: its step was accepted and gave no {name}, needed: Step({name}=...)")
        if np.shape(given) != field.shape:
            raise WrongAnswer(f"{self.name}: its step gave {name} of shape {np.shape(given)}, needed: {field.shape}")
        field[...] = given


def _refuse_step(count: float, time: float, dt: float) -> None:
    raise SimulationFailure(
        "failed",
        f"step {count:.0f}: the clock stands at {time:.6g} s, as a step of {dt:.3g} s does not move it; try a longer "
        "time.step, or look at the stiffness and density of the bodies, from which the stable step follows",
    )
