"""Explicit integrators by primitives, in files of their own: velocity Verlet, and steps that misuse the primitives."""

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


@dataclass(frozen=True)
class Wrong(ExplicitIntegrator):
    """One flaw in the use of primitives, or none."""

    flaw: str = ""
    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2

    def step(self, motion: Motion, dt: float) -> None:
        flaw = self.flaw
        ahead = {"contact of another time": 0.5 * dt, "contact now": 0.0}.get(flaw, dt)
        if flaw == "contact before the kick":
            motion.contact(ahead)
        if flaw != "no kick":
            motion.kick({"no half step at the start": dt, "no time": 0.0}.get(flaw, 0.5 * (motion.last_dt + dt)))
        if flaw != "no contact":
            motion.contact(ahead)
        if flaw == "contact twice":
            motion.contact(ahead)
        if flaw != "no drift":
            motion.drift(0.5 * dt if flaw == "half a step" else dt)
        if flaw == "kicks twice":
            motion.kick(dt)


@hookimpl
def contactlab_parts() -> list[Part]:
    return [
        Part("integrator", "verlet", "primitives:Verlet", "velocity Verlet"),
        Part("integrator", "wrong-primitives", "primitives:Wrong", "misuses the primitives"),
    ]
