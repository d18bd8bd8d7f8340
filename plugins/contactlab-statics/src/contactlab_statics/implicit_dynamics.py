"""Implicit dynamics: the midpoint rule, contact held in positions and in velocities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Floats, ImplicitIntegrator, ImplicitMotion
from contactlab_statics.limits import refuse_limits

STEPS = 500
"""Steps in time if the scene names no number."""
BACKWARD = 0.5
"""Dissipation with which stresses are taken at the end of a step."""


@dataclass(frozen=True)
class ImplicitDynamics(ImplicitIntegrator):
    """Stresses in the middle of a step, contact forces that hold gaps at its end, velocities that keep them held.

    Gaps are complementary to forces at the end of every step, and closed surfaces leave it with equal normal
    velocities: contact takes energy (of the nodes which are stopped) and never gives any
    (docs/statics.md). Linear and angular momentum are kept. Without contact the scheme is second order and has no
    damping of its own.

    steps        equal steps to try for the whole run; not written: 500, and at least 10 for each way of a value that
                 alternates
    tolerance    as with `newton`: residuals at which a step is accepted
    iterations   most iterations of a step before it is cut
    dissipation  share of a step by which stresses lead its middle: a viscosity of stiffness times
                 dissipation * dt, booked as `numerical`; first order unless it is 0, and angular momentum changes [-];
                 not written: 0, and 0.5 in quasi-static runs, where vibrations that steps do not resolve have to fade
    impacts      whether a step in which surfaces meet at a speed that matters ends where they meet, and later steps
                 are short enough to follow the contact; if not, how fast bodies rebound depends on the step
    """

    steps: int | None = None
    tolerance: float = 1e-8
    iterations: int = 25
    dissipation: float | None = None
    impacts: bool = True

    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    without: ClassVar[Mapping[str, str]] = {"inertia": "newton"}
    by_default: ClassVar[bool] = True

    def __post_init__(self) -> None:
        refuse_limits(self.wished_steps(), self.tolerance, self.iterations)
        if self.dissipation is not None and not 0.0 <= self.dissipation <= BACKWARD:
            raise ValueError(f"dissipation: got {self.dissipation}, allowed: 0 to {BACKWARD} (backward Euler stresses)")

    def wished_steps(self) -> int:
        """Return the number of steps of the scene, or the default."""
        return STEPS if self.steps is None else self.steps

    def fixes_steps(self) -> bool:
        """Return whether the scene sets `steps`."""
        return self.steps is not None

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Limit of steps around impacts, and the energies that they are judged by."""
        return {"impact": (3,)} if self.impacts else {}

    def step(self, motion: ImplicitMotion, dt: float) -> None:
        """Balance forces in the middle of the step: u+ - u = dt (v + v+)/2 and a = (v+ - v)/dt."""
        v, backward = motion.velocity, BACKWARD if motion.quasi_static else 0.0

        def velocity(moved: Floats) -> Floats:
            return 2.0 * (moved / dt) - v

        def acceleration(moved: Floats) -> Floats:
            return (velocity(moved) - v) / dt

        motion.solve(velocity, acceleration, at=0.5, lead=backward if self.dissipation is None else self.dissipation)
