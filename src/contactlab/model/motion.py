"""Explicit steps by primitives: the core handles work, reactions, prescribed motion and positions."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ExplicitEquations, ExplicitIntegrator, Floats, State, Step
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.compiled.late import late
from contactlab.errors import WrongAnswer

ROUND_OFF = 1e-12  # relative: drifts of a step sum to its length up to round-off
POWERS = 512  # products of forces and velocities that are summed at a time


class ExplicitMotion:
    """Implements `contactlab.api.Motion` on one run's arrays, bound at the first step.

    A kick is made together with the contact and the drift after it, so that prescribed motion ends as it
    should and every force works with the mean of the velocities before and after.

    mobility   (N, 2) [1/t] inverse masses, 0 if motion is prescribed
    start      time [s] at the start of the step
    duration   of the pending kick [s]; 0 without one; `touched` of the last kick with contact
    moved      time [s] that positions have moved in this step; `kicked` the sum of its kicks
    ahead      time [s] after which the contact forces of this kick hold the gaps; 0 without
    """

    def __init__(self, integrator: ExplicitIntegrator, equations: ExplicitEquations, state: State) -> None:
        nodes, touching = len(equations.reference), equations.contact is not None
        self.scheme, self.name = integrator.step, type(integrator).__name__
        self.equations, self.state, self.pairs = equations, state, equations.contact
        self.loads, self.stresses, self.ramps = (
            equations.external_force, equations.internal_force, equations.prescribed.values
        )  # fmt: skip
        self.clock, self.work, self.reaction = state["clock"], state["work"], state["reaction"]
        inverse_mass = np.divide(1.0, equations.mass, out=np.zeros(nodes), where=equations.mass > 0.0)
        self.mobility: Floats = np.repeat(inverse_mass, 2).reshape(-1, 2)
        self.mobility.reshape(-1)[equations.prescribed.dof] = 0.0
        self.external, self.mean = np.zeros((nodes, 2)), np.zeros((nodes, 2))
        self.compliance, self.predicted = (np.zeros((nodes if touching else 0, 2)) for _ in range(2))
        self.compliance_factor = 0.0
        self.following = 0.5 / equations.relaxation if equations.relaxation else 0.0
        self.damping, self.loaded = 0.0, False
        self.force = state["contact_force"] if touching else np.zeros((0, 2))
        self.start = self.last_dt = self.moved = self.kicked = self.touched = self.duration = self.ahead = 0.0
        self.plain = self.done = Step(self.work, self.reaction)
        self.bound: BoundArrays | None = None

    def advance(self, dt: float) -> Step:
        """Make one step of length dt [s] by the integrator's primitives."""
        if self.bound is None:
            self._bind()
        clock = self.clock
        self.start, self.last_dt = float(clock[0]), float(clock[2])
        self.moved = self.kicked = 0.0
        self.done = self.plain
        error = self.scheme(self, dt)
        if self.duration > 0.0:
            self._move(0.0)
        if self.kicked != self.touched and self.done is not self.plain:
            raise WrongAnswer(f"{self.name}: its step kicks again with contact, needed: one kick a step")
        if self.moved != dt and abs(self.moved - dt) > ROUND_OFF * dt:
            raise WrongAnswer(f"{self.name}: its step of {dt:.6g} s drifts for {self.moved:.6g} s, needed: its length")
        return self.done if error is None else self.done._replace(error=error)

    def kick(self, duration: float) -> None:
        """See `contactlab.api.Motion`."""
        if not duration > 0.0:
            raise WrongAnswer(f"{self.name}: its step kicks for {duration:.6g} s, needed: a positive time")
        if self.duration > 0.0:
            self._move(0.0)
        self.loaded = self.loads(self.start + self.moved, self.external)
        # the slow velocity starts at its value before the kick, and follows until the velocities' mean
        self.damping = self.equations.damping / (1.0 + duration * self.following)
        self.duration = duration
        self.kicked += duration

    def contact(self, ahead: float) -> None:
        """See `contactlab.api.Motion`."""
        if self.pairs is None:
            return
        duration, damping = self.duration, self.damping
        if duration == 0.0 or self.ahead > 0.0:
            raise WrongAnswer(f"{self.name}: its step asks for contact forces without a kick, needed: one kick before")
        if not ahead > 0.0:
            raise WrongAnswer(f"{self.name}: its step asks for contact {ahead:.6g} s ahead, needed: a positive time")
        self.ahead, self.touched = ahead, duration
        self.ramps(self.start + self.moved + ahead)
        self.predict(self.address, self.loaded, damping, ahead, duration)
        factor = ahead * duration / (1.0 + 0.5 * damping * duration)
        if factor != self.compliance_factor:
            self.compliance_factor = factor
            np.multiply(self.mobility, factor, out=self.compliance)
        solve = self.pairs.solve(self.predicted, self.equations.position, self.compliance, self.force)
        self.done = Step(self.work, self.reaction, sweeps=solve.sweeps, residual=solve.residual)

    def drift(self, duration: float) -> None:
        """See `contactlab.api.Motion`."""
        if self.duration == 0.0 or not duration > 0.0:
            raise WrongAnswer(f"{self.name}: its step drifts for {duration:.6g} s without a kick, needed: one before")
        if self.ahead == 0.0:
            self.ramps(self.start + self.moved + duration)
            self._move(duration)
        elif duration == self.ahead:
            self.correct(self.address, self.loaded, self.damping, duration, self.duration)
            self.duration = self.ahead = 0.0
            self._book_friction()
        else:
            raise WrongAnswer(
                f"{self.name}: its step drifts for {duration:.6g} s, and asked for contact {self.ahead:.6g} s ahead, "
                "needed: the same time"
            )
        self.moved += duration
        self.stresses(duration)

    def acceleration(self) -> Floats:
        """See `contactlab.api.Motion`."""
        loads = np.zeros_like(self.external)
        self.loads(self.start + self.moved, loads)
        return np.asarray(self.mobility * (loads - self.state["internal_force"]))

    def _move(self, drift: float) -> None:
        """Make the pending kick without contact, move positions for the time `drift`, and book both."""
        if self.ahead > 0.0:
            raise WrongAnswer(f"{self.name}: its step asks for contact and does not drift, needed: a drift after it")
        self.move(self.address, self.loaded, self.damping, drift, self.duration, self.duration / self.kicked)
        self.duration = 0.0

    def _book_friction(self) -> None:
        """Move the tangential share of the contact work to its own entries."""
        pairs: Any = self.pairs
        rubbed, dissipated = pairs.friction_work(self.mean, self.touched, self.compliance, self.force)
        if rubbed == dissipated == 0.0:
            return
        work = self.work
        work[3] -= rubbed
        work[4] += rubbed
        work[6] += dissipated

    def _bind(self) -> None:
        kernels = late("contactlab.kernels.motion")
        self.move, self.predict, self.correct = kernels.move, kernels.predict, kernels.correct
        equations, state, prescribed = self.equations, self.state, self.equations.prescribed
        fields: dict[str, Any] = {
            "reference": equations.reference, "displacement": state["displacement"], "velocity": state["velocity"],
            "internal": state["internal_force"], "external": self.external, "mobility": self.mobility,
            "mass": equations.mass, "dof": prescribed.dof, "scale": prescribed.scale, "ramp": prescribed.ramp,
            "ramps": prescribed.values(0.0), "before": np.zeros(len(prescribed.dof)), "trial": self.mean,
            "predicted": self.predicted, "contact": self.force, "compliance": self.compliance,
            "reaction": self.reaction, "work": self.work, "products": np.zeros(POWERS),
            "carried": state["drift"] if "drift" in state else np.zeros(0),
            "relaxation": np.array([equations.relaxation]),
        }  # fmt: skip
        table = kernels.MotionTable(**{name: field.reshape(-1) for name, field in fields.items()})
        self.bound = BoundArrays(kernels.MotionTable, *table)
        self.address = self.bound.address
