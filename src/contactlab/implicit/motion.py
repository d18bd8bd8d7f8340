"""Implicit steps by one primitive: the core iterates, books work and reactions, and restores failed steps.

Quasi-static load increments are in `contactlab.implicit.load_step`, steps in time in `contactlab.implicit.time_step`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from contactlab.api import Floats, ImplicitEquations, ImplicitIntegrator, State, Step, StepStatus
from contactlab.api.motion import OfMotion
from contactlab.errors import WrongAnswer
from contactlab.implicit.iteration import Outcome, take_back
from contactlab.implicit.load_step import LoadStep
from contactlab.implicit.relaxation import Relaxation
from contactlab.implicit.time_step import Scheme, TimeStep


class NotSolved(ArithmeticError):
    """Signal of a step without a solution found by the iteration: `step` of the integrator ends here."""


class SolvedMotion:
    """Implements `contactlab.api.ImplicitMotion` on one run's arrays.

    dt       length of the step [s]
    outcome  of the iteration of this step; None before it
    """

    def __init__(self, integrator: ImplicitIntegrator, equations: ImplicitEquations, state: State) -> None:
        self.scheme, self.name = integrator.step, type(integrator).__name__
        self.limits = integrator.tolerance, integrator.iterations
        self.equations, self.state, self.quasi_static = equations, state, equations.quasi_static
        self.velocity: Floats = np.zeros((len(equations.reference) if "velocity" in state else 0, 2))
        self.dt = self.last_dt = 0.0
        self.outcome: Outcome | None = None

    @cached_property
    def statics(self) -> LoadStep:
        """Load steps of this run."""
        return LoadStep(self.equations, self.state, *self.limits)

    @cached_property
    def stabilised(self) -> Relaxation:
        """Load steps of this run that pass a loss of equilibrium."""
        return Relaxation(self.statics)

    @cached_property
    def dynamics(self) -> TimeStep:
        """Steps in time of this run."""
        return TimeStep(self.equations, self.state, *self.limits)

    def advance(self, dt: float) -> Step:
        """Make one step of length dt [s] by the integrator's `step`, or restore the state."""
        state, start = self.state, self.state.snapshot()
        self.dt, self.last_dt, self.outcome, error = dt, state.last_dt, None, None
        if len(self.velocity):
            self.velocity[:] = state["velocity"]
        try:
            error = self.scheme(self, dt)  # the integrator's `step`, which calls back `solve`
        except NotSolved:
            take_back(self.equations, state, start)
        done = self.outcome
        if done is None:
            raise WrongAnswer(f"{self.name}: its step does not solve, needed: motion.solve() once in each step")
        residual = done.residual.largest if done.reason else done.residual.contact
        return Step(
            state["work"], state["reaction"], StepStatus.not_converged if done.reason else StepStatus.accepted,
            iterations=len(done.trace), residual=residual, reason=done.reason, trace=tuple(done.trace),
            error=error, longest=done.longest,
        )  # fmt: skip

    def solve(
        self,
        velocity: OfMotion | None = None,
        acceleration: OfMotion | None = None,
        at: float = 1.0,
        lead: float = 0.0,
    ) -> Floats:
        """See `contactlab.api.ImplicitMotion`."""
        if self.outcome is not None:
            raise WrongAnswer(
                f"{self.name}: its step solves twice, needed: motion.solve() once in each step; a scheme of several "
                "stages makes each a step, and finds the next one in its memory"
            )
        if (velocity is None or acceleration is None) == ("velocity" in self.state):
            raise WrongAnswer(
                f"{self.name}: its step solves for motion by halves, needed: velocity and acceleration if the class "
                "has inertia, else neither"
            )
        if velocity is None or acceleration is None:
            self.outcome = (self.stabilised if self.equations.stabilised else self.statics).solve(self.dt)
        else:
            if not 0.0 < at <= at + lead <= 1.0:
                raise WrongAnswer(f"{self.name}: solve got at = {at}, lead = {lead}, needed: 0 < at <= at + lead <= 1")
            rates = self._rate(velocity), self._rate(acceleration)
            self.outcome = self.dynamics.solve(self.dt, Scheme(velocity, acceleration, at, lead, *rates))
        if self.outcome.reason:
            raise NotSolved
        return self.outcome.motion

    def acceleration(self) -> Floats:
        """See `contactlab.api.ImplicitMotion`."""
        return self.dynamics.acceleration()

    def _rate(self, function: OfMotion) -> float:
        """Return the derivative of an affine function, without round-off: its imaginary part."""
        rates = np.imag(function(np.full(self.velocity.shape, 1j))).ravel()
        if not rates[0] > 0.0 or (rates != rates[0]).any():
            raise WrongAnswer(
                f"{self.name}: solve got a function of the motion that changes by {rates.min():.6g} to "
                f"{rates.max():.6g} with it, needed: an affine one, with one rate > 0"
            )
        return float(rates[0])
