"""Motion: the primitives of integrator steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from contactlab.api.arrays import Floats
from contactlab.api.state import State

OfMotion = Callable[[Floats], Floats]
"""Affine function of the motion (N, 2) [mm] of all nodes in a step; its rate is its value at an imaginary motion."""


class Motion(Protocol):
    """A run for `ExplicitIntegrator.step`: primitives that move the state and book their work.

    Kicks change velocities, drifts change positions. The core handles work, reactions, damping, loads, prescribed
    motion, friction and stresses. The drifts of a step sum to its length, and each follows a kick.

    state    after the last primitive: read only, except for the integrator's own `memory`
    last_dt  length of the last step [s]; 0 before the first
    """

    state: State
    last_dt: float

    def kick(self, duration: float) -> None:
        """Apply stresses and loads of this moment to velocities for a time [s], with the damping at its middle."""

    def contact(self, ahead: float) -> None:
        """Add to the kick the contact forces that hold the gaps at the end of the next drift, `ahead` [s] from now.

        They act as long as the kick, the only kick of the step: velocities between two kicks would lack them, and
        stresses be booked with work that they did not do. Does nothing in a scene without contact.
        """

    def drift(self, duration: float) -> None:
        """Move positions with the velocities for a time [s], and compute the stresses there."""

    def acceleration(self) -> Floats:
        """Return accelerations (N, 2) [mm/s^2] by stresses and loads of this moment, 0 if motion is prescribed."""


class ImplicitMotion(Protocol):
    """A run for `ImplicitIntegrator.step`: a primitive that finds the end of the step.

    state         at the start of the step before `solve`, at its end after it: read only, except for the integrator's
                  own `memory`
    velocity      (N, 2) [mm/s] at the start of the step
    last_dt       length of the last step [s]; 0 before the first
    quasi_static  True if a run with inertia ends when its motion has faded (`end = "auto"`)
    """

    state: State
    velocity: Floats
    last_dt: float
    quasi_static: bool

    def solve(
        self, velocity: OfMotion | None = None, acceleration: OfMotion | None = None, at: float = 1.0, lead: float = 0.0
    ) -> Floats:
        """Find the end of the step with balanced forces and satisfied contact; once in each step, or stage of a scheme.

        velocity      at the end of the step, acceleration  in the balance of forces: affine functions of the motion
                      (N, 2) [mm] in the step, as the scheme relates them. Statics have neither
        at            share of the step at which forces balance: loads, damping and stresses belong to this share of
                      the way, or of the time, from start to end
        lead          share of the step by which stresses are ahead of it; their excess over mid-step stresses is
                      booked as numerical dissipation

        The core handles Newton's iteration, contact, prescribed motion, work and reactions; a step without a solution
        leaves `step` here, is restored, and is tried again with a shorter length. Contact forces y are outside the
        scheme: they act evenly over the step, and move nodes by y dt^2/(2 m) and velocities by y dt/m. Velocities of
        closed contacts are then corrected by impulses, so that surfaces leave the step together.

        Returns the motion (N, 2) [mm] in the step without the motion by contact forces, to which the functions of the
        scheme apply.
        """

    def acceleration(self) -> Floats:
        """Return accelerations (N, 2) [mm/s^2] by stresses, loads and damping, 0 if motion is prescribed."""
