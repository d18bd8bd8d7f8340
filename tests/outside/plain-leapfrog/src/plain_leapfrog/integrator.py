"""Central differences with contact, friction, damping and an energy ledger, in plain NumPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ExplicitEquations, ExplicitIntegrator, Floats, State, Step


@dataclass(frozen=True)
class PlainLeapfrog(ExplicitIntegrator):
    """Velocities half a step behind positions, from the middle of the last step to that of the next."""

    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2

    def bind(self, equations: ExplicitEquations, state: State) -> Callable[[float], Step]:
        """Bind the arrays of one run."""
        return _Run(equations, state).step


class _Run:
    """One run's arrays.

    mobility  (N, 2) [1/t] of single nodes, 0 where motion is prescribed
    """

    def __init__(self, equations: ExplicitEquations, state: State) -> None:
        self.equations, self.state = equations, state
        self.mass = equations.mass[:, None]
        self.mobility = np.divide(1.0, self.mass, out=np.zeros((len(self.mass), 2)), where=self.mass > 0.0)
        self.mobility.reshape(-1)[equations.prescribed.dof] = 0.0
        self.load = np.zeros((len(self.mass), 2))

    def step(self, dt: float) -> Step:
        """Advance the state by dt."""
        equations, u, v = self.equations, self.state["displacement"], self.state["velocity"]
        held, alpha = equations.prescribed, equations.damping
        internal, before = self.state["internal_force"].copy(), v.copy()
        equations.external_force(self.state.time, self.load)
        between = 0.5 * (self.state.last_dt + dt)  # half a step at the start, where v is that of t = 0
        loss = 0.5 * alpha * between
        v[:] = ((1.0 - loss) * v + between * self.mobility * (self.load - internal)) / (1.0 + loss)
        target = held.scale * held.values(self.state.time + dt)[held.ramp]
        v.reshape(-1)[held.dof] = (target - u.reshape(-1)[held.dof]) / dt
        touch, rubbed, dissipated = self._touch(dt, between, dt * between / (1.0 + loss) * self.mobility, before)
        mean = 0.5 * (before + v)
        reaction = np.zeros_like(u)
        needed = self.mass * ((v - before) / between + alpha * mean) + internal - self.load - touch
        reaction.reshape(-1)[held.dof] = needed.reshape(-1)[held.dof]
        forces = (internal, self.load + reaction, alpha * self.mass * mean, touch)
        inner, outer, damped, pushed = (between * float(np.vdot(mean, force)) for force in forces)
        work = self.state["work"] + np.array([inner, outer, damped, pushed - rubbed, rubbed, 0.0, dissipated])
        u += dt * v
        equations.internal_force(dt)
        return Step(work, reaction)

    def _touch(self, dt: float, between: float, compliance: Floats, before: Floats) -> tuple[Floats, float, float]:
        """Contact forces, which correct the velocities, and work and dissipation of friction."""
        contact, state = self.equations.contact, self.state
        if contact is None:
            return np.zeros_like(before), 0.0, 0.0
        force, v = state["contact_force"], state["velocity"]
        predicted = self.equations.reference + state["displacement"] + dt * v
        contact.solve(predicted, self.equations.position, compliance, force)
        v += compliance * force / dt
        return force, *contact.friction_work(0.5 * (before + v), between, compliance, force)
