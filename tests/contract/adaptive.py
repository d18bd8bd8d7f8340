"""Integrators of another package whose steps follow an estimate of their error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from contactlab_statics.implicit_dynamics import ImplicitDynamics

from contactlab.api import ExplicitIntegrator, ImplicitEquations, Motion, State, Step, StepControl
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class AdaptiveLeapfrog(ExplicitIntegrator):
    """Central differences; the acceleration changes by jerk times dt in a step, which leaves dt^3 jerk / 12.

    allowed  error of a step [mm]
    """

    allowed: float = 1e-6
    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2

    def control(self) -> StepControl:
        return StepControl(order=3)

    def step(self, motion: Motion, dt: float) -> float:
        before = motion.acceleration()
        motion.kick(0.5 * (motion.last_dt + dt))
        motion.contact(ahead=dt)
        motion.drift(dt)
        change = motion.acceleration() - before
        return float(dt**2 / 12.0 * np.hypot(*change.T).max() / self.allowed)


@dataclass(frozen=True)
class AdaptiveMidpoint(ImplicitDynamics):
    """Implicit dynamics with the same estimate.

    allowed  error of a step [mm]
    """

    allowed: float = 1e-6

    def control(self) -> StepControl:
        return StepControl(order=3)

    def bind(self, equations: ImplicitEquations, state: State) -> Callable[[float], Step]:
        inner, mass = super().bind(equations, state), np.maximum(equations.mass, 1e-300)[:, None]
        free = np.ones(2 * len(mass), bool)
        free[equations.prescribed.dof] = False

        def accelerations() -> Any:
            return -state["internal_force"] / mass * free.reshape(-1, 2)

        def step(dt: float) -> Step:
            before = accelerations()
            done = inner(dt)
            error = dt**2 / 12.0 * np.abs(accelerations() - before).max() / self.allowed
            return done._replace(error=float(error))

        return step


@dataclass(frozen=True)
class Silent(ExplicitIntegrator):
    """Asks for control and reports no error."""

    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2

    def control(self) -> StepControl:
        return StepControl(order=3)

    def step(self, motion: Motion, dt: float) -> None:
        motion.kick(0.5 * (motion.last_dt + dt))
        motion.drift(dt)


@hookimpl
def contactlab_parts() -> list[Part]:
    return [
        Part("integrator", "adaptive-leapfrog", "adaptive:AdaptiveLeapfrog", "steps follow their error"),
        Part("integrator", "adaptive-midpoint", "adaptive:AdaptiveMidpoint", "implicit steps follow their error"),
        Part("integrator", "silent", "adaptive:Silent", "reports no error"),
    ]
