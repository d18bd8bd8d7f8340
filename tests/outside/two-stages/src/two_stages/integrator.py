"""Composite implicit steps: a stage by the trapezoidal rule, then one by backward differences."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Floats, ImplicitIntegrator, ImplicitMotion
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class TwoStages(ImplicitIntegrator):
    """TR-BDF2 (Bank et al. 1985; Bathe & Baig 2005): second order, removes the highest frequencies.

    Each stage is a step of the run, so it has contact of its own and may be cut by itself.

    steps  of the run, two for each pair of stages
    """

    steps: int = 200

    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    dissipates: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise ValueError(f"steps: got {self.steps}, allowed: >= 1")

    def wished_steps(self) -> int:
        """As the scene has it."""
        return self.steps

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Which stage is next; motion of the last stage, its gain of velocity, and the velocity at its end."""
        return {"stage": (1,), "moved": (nodes, 2), "gained": (nodes, 2), "reached": (nodes, 2)}

    def step(self, motion: ImplicitMotion, dt: float) -> None:
        """Make one stage."""
        stage, moved, gained, reached = (motion.state[name] for name in ("stage", "moved", "gained", "reached"))
        v, a, last = motion.velocity, motion.acceleration(), motion.last_dt
        # contact has changed velocities by v - reached: the last stage is taken as if it had begun faster by that
        before = moved + last * (v - reached)
        r = dt / last if last else 1.0
        this, other = (1 + 2 * r) / (1 + r) / dt, r**2 / (1 + r) / dt

        def velocity(d: Floats) -> Floats:
            return this * d - other * before if stage else 2 / dt * d - v

        def acceleration(d: Floats) -> Floats:
            change = velocity(d) - v
            return this * change - other * gained if stage else 2 / dt * change - a

        moved[:] = motion.solve(velocity, acceleration)
        reached[:] = velocity(moved)
        gained[:] = reached - v
        stage[:] = 1 - stage


@hookimpl
def contactlab_parts() -> list[Part]:
    """One integrator."""
    return [Part("integrator", "two-stages", f"{__name__}:TwoStages", "TR-BDF2, a stage a step", "Bank et al. 1985")]
