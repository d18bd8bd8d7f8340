"""Explicit central differences with contact forces in the same step (docs/theory/explicit-scheme.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from contactlab.api import (
    ContactEquations,
    ExplicitEquations,
    ExplicitIntegrator,
    Floats,
    State,
    Step,
)
from contactlab.api.compiled.bound_arrays import BoundArrays


@dataclass(frozen=True)
class CentralDifference(ExplicitIntegrator):
    """Leapfrog with lumped mass; velocities live half a step before positions.

    forces  of contacts that name no enforcement: "consistent" or "frozen", see `forward-increment`; "auto" leaves it to
            that part. Consistent ones cost 1.3 to 1.9 times as much contact (docs/theory/contact-energy.md)
    """

    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2
    without: ClassVar[Mapping[str, str]] = {"inertia": "newton"}

    forces: Literal["auto", "consistent", "frozen", "conjugate", "published"] = "auto"

    def enforcement(self) -> Mapping[str, Any]:
        """Multipliers by forward increments, with the forces that are asked for."""
        own: dict[str, Any] = {"use": self.default_enforcement}
        return own if self.forces == "auto" else own | {"forces": self.forces}

    def bind(self, equations: ExplicitEquations, state: State) -> Callable[[float], Step]:
        """The step function; the first step starts from v_0 (half a step of acceleration)."""
        return _Leapfrog(equations, state).step


class _Leapfrog:
    """Steps of the central difference scheme on one run's arrays, bound once."""

    def __init__(self, equations: ExplicitEquations, state: State) -> None:
        nodes = len(equations.reference)
        self.equations, self.state = equations, state
        self.clock, self.work, self.reaction = state["clock"], state["work"], state["reaction"]
        self.done = Step(self.work, self.reaction)
        inverse_mass = np.divide(1.0, equations.mass, out=np.zeros(nodes), where=equations.mass > 0.0)
        self.mobility: Floats = np.repeat(inverse_mass, 2).reshape(-1, 2)
        self.mobility.reshape(-1)[equations.prescribed.dof] = 0.0
        self.before = np.zeros(len(equations.prescribed.dof))
        self.trial, self.external = np.zeros((nodes, 2)), np.zeros((nodes, 2))
        self.products = np.zeros(512)
        touching = equations.contact is not None
        self.compliance, self.predicted = (np.zeros((nodes if touching else 0, 2)) for _ in range(2))
        self.compliance_dt = 0.0
        self.following = 0.5 / equations.relaxation if equations.relaxation else 0.0
        self.contact = state["contact_force"] if touching else np.zeros((0, 2))
        self.bound: BoundArrays | None = None

    def step(self, dt: float) -> Step:
        """Advance the state in place by one step of length dt [s]."""
        equations = self.equations
        bound = self.bound or self._bind()
        time = float(self.clock[0])
        # at the start only half a step of acceleration leads from v_0 to v_{1/2}
        mean_dt = 0.5 * (float(self.clock[2]) + dt)
        loaded = equations.external_force(time, self.external)
        equations.prescribed.values(time + dt)
        # the drift is that of half a step ago, and follows until the velocities' mean
        damping = equations.damping / (1.0 + mean_dt * self.following)
        now = (bound.address, loaded, damping, dt, mean_dt)
        done = self.done
        if equations.contact is None:
            self.move(*now)
        else:
            self.predict(*now)
            done = self._contact(equations.contact, now)
        equations.internal_force(dt)
        return done

    def _bind(self) -> BoundArrays:
        """Bind all arrays and kernels at the first step."""
        from contactlab_dynamics import leapfrog

        equations, state = self.equations, self.state
        self.move, self.predict, self.correct = leapfrog.move, leapfrog.predict, leapfrog.correct
        prescribed = equations.prescribed
        fields = (
            equations.reference, state["displacement"], state["velocity"], state["internal_force"], self.external,
            self.mobility, equations.mass, prescribed.dof, prescribed.scale, prescribed.ramp, prescribed.values(0.0),
            self.before, self.trial, self.predicted, self.contact, self.compliance, self.reaction, self.work,
            self.products, state["drift"] if "drift" in state else np.zeros(0), np.array([equations.relaxation]),
        )  # fmt: skip
        self.bound = BoundArrays(leapfrog.ARRAYS, *(field.reshape(-1) for field in fields))
        return self.bound

    def _contact(self, contact: ContactEquations, now: tuple[int, bool, float, float, float]) -> Step:
        """Contact forces of the step, and with them its end; `now` is what kernels are told of the step."""
        _, _, damping, dt, mean_dt = now
        self._set_compliance(dt, mean_dt, damping)
        solve = contact.solve(self.predicted, self.equations.position, self.compliance, self.contact)
        self.correct(*now)
        self._book_friction(contact, mean_dt)
        return Step(self.work, self.reaction, sweeps=solve.sweeps, residual=solve.residual)

    def _book_friction(self, contact: ContactEquations, mean_dt: float) -> None:
        """Move the tangential share of the contact work to its own entries (`trial` holds mean velocities)."""
        rubbed, dissipated = contact.friction_work(self.trial, mean_dt, self.compliance, self.contact)
        if rubbed == dissipated == 0.0:
            return
        work = self.work
        work[3] -= rubbed
        work[4] += rubbed
        work[6] += dissipated

    def _set_compliance(self, dt: float, mean_dt: float, alpha: float) -> None:
        factor = dt * mean_dt / (1.0 + 0.5 * alpha * mean_dt)
        if factor != self.compliance_dt:
            self.compliance_dt = factor
            np.multiply(self.mobility, factor, out=self.compliance)
