"""Explicit central differences with contact forces in the same step (docs/theory/explicit-scheme.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import (
    ContactEquations,
    Enforcement,
    Equations,
    ExplicitEnforcement,
    Floats,
    Integrator,
    State,
    Step,
)


@dataclass(frozen=True)
class CentralDifference(Integrator):
    """Leapfrog with lumped mass; velocities live half a step before positions."""

    needs: ClassVar[type[Enforcement]] = ExplicitEnforcement
    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    explicit: ClassVar[bool] = True
    without: ClassVar[Mapping[str, str]] = {"inertia": "newton"}

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Last step length, and reactions (N, 2) [N] of supports at the start of the last step."""
        return {"last_dt": (1,), "reaction": (nodes, 2)}

    def bind(self, equations: Equations, state: State) -> Callable[[float], Step]:
        """The step function; the first step starts from v_0 (half a step of acceleration)."""
        return _Leapfrog(equations, state).step


class _Leapfrog:
    """One run's arrays, bound once."""

    def __init__(self, equations: Equations, state: State) -> None:
        nodes = len(equations.reference)
        self.equations, self.state = equations, state
        inverse_mass = np.divide(1.0, equations.mass, out=np.zeros(nodes), where=equations.mass > 0.0)
        self.mobility: Floats = np.repeat(inverse_mass, 2).reshape(-1, 2)
        self.mobility.reshape(-1)[equations.prescribed.dof] = 0.0
        self.before = np.zeros(len(equations.prescribed.dof))
        self.trial, self.external = np.zeros((nodes, 2)), np.zeros((nodes, 2))
        self.products = np.zeros(512)
        touching = equations.contact is not None
        self.compliance, self.predicted = (np.zeros((nodes if touching else 0, 2)) for _ in range(2))
        self.compliance_dt = 0.0
        self.contact = state["contact_force"] if touching else np.zeros((0, 2))

    def step(self, dt: float) -> Step:
        """Advance the state by dt."""
        from contactlab_dynamics import leapfrog

        equations, state = self.equations, self.state
        clock, last = state["clock"], state["last_dt"]
        # at the start only half a step of acceleration leads from v_0 to v_{1/2}
        mean_dt = 0.5 * (last[0] + dt)
        loaded = equations.external_force(clock[0], self.external)
        prescribed = equations.prescribed
        forces = (
            state["displacement"], state["velocity"], state["internal_force"], self.external, loaded, self.mobility,
            equations.damping, dt, mean_dt, prescribed.dof, prescribed.scale, prescribed.ramp,
            prescribed.values(clock[0] + dt),
        )  # fmt: skip
        done = Step()
        if equations.contact is None:
            leapfrog.move(*forces, self.before, self.trial)
        else:
            leapfrog.predict(equations.reference, *forces, self.trial, self.predicted)
            done = self._contact(equations.contact, dt, mean_dt)
        leapfrog.book(
            equations.mass, self.external, loaded, self.contact, equations.contact is not None,
            state["internal_force"], equations.damping, mean_dt, prescribed.dof, self.before, state["velocity"],
            self.trial, state["reaction"], state["work"], self.products,
        )  # fmt: skip
        if equations.contact is not None:
            self._book_friction(equations.contact, mean_dt)
        last[0] = dt
        clock[0] += dt
        clock[1] += 1.0
        equations.internal_force(dt)
        return done

    def _contact(self, contact: ContactEquations, dt: float, mean_dt: float) -> Step:
        """Contact forces of the step, and with them its end."""
        from contactlab_dynamics import leapfrog

        self._set_compliance(dt, mean_dt, self.equations.damping)
        solve = contact.solve(self.predicted, self.equations.position, self.compliance, self.contact)
        leapfrog.correct(
            self.contact, self.compliance, dt, self.equations.prescribed.dof, self.before, self.trial,
            self.state["displacement"], self.state["velocity"],
        )  # fmt: skip
        return Step(sweeps=solve.sweeps, residual=solve.residual)

    def _book_friction(self, contact: ContactEquations, mean_dt: float) -> None:
        """Move the tangential share of the contact work to its own entries (`trial` holds mean velocities)."""
        work = self.state["work"]
        rubbed, dissipated = contact.friction_work(self.trial, mean_dt, self.compliance, self.contact)
        work[3] -= rubbed
        work[4] += rubbed
        work[6] += dissipated

    def _set_compliance(self, dt: float, mean_dt: float, alpha: float) -> None:
        factor = dt * mean_dt / (1.0 + 0.5 * alpha * mean_dt)
        if factor != self.compliance_dt:
            self.compliance_dt = factor
            np.multiply(self.mobility, factor, out=self.compliance)
