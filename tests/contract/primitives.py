"""An explicit integrator by primitives, in a file of its own: velocity Verlet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import ExplicitIntegrator, Motion
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Verlet(ExplicitIntegrator):
    """Two half kicks around a drift, without contact."""

    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2
    velocity_lag: ClassVar[float] = 0.0

    def step(self, motion: Motion, dt: float) -> None:
        motion.kick(0.5 * dt)
        motion.drift(dt)
        motion.kick(0.5 * dt)


@hookimpl
def contactlab_parts() -> list[Part]:
    return [Part("integrator", "verlet", "primitives:Verlet", "velocity Verlet")]
