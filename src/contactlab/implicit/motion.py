"""Implicit steps by one primitive: the core iterates, books work and reactions, and restores failed steps.

Quasi-static load increments predict, iterate and book here; steps in time are in `contactlab.implicit.time_step`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from contactlab.api import WORK, Estimate, Floats, ImplicitEquations, ImplicitIntegrator, State, Step, StepStatus
from contactlab.api.motion import OfMotion
from contactlab.errors import WrongAnswer
from contactlab.implicit.factor import with_diagonal
from contactlab.implicit.free_motions import FreeMotions
from contactlab.implicit.iteration import NewtonIteration, Outcome, take_back
from contactlab.implicit.relaxation import Relaxation
from contactlab.implicit.time_step import Scheme, TimeStep
from contactlab.implicit.trial import ContactForces

LIMITED = 3  # shortened corrections if bodies flow as in the step before: a shorter step costs less
FARTHEST = 4.0  # times the step before: no extrapolation beyond
ALONG = 0.9  # cosine between the motions of two steps, below which the loading turns
INTERNAL, EXTERNAL, CONTACT, FRICTION, SLIP = (
    WORK.index(name) for name in ("internal", "external", "contact", "friction", "slip")
)


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
            self.outcome = self.statics.solve(self.dt)
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


# --- load increments ------------------------------------------------------------------------------------------------


class LoadStep:
    """Makes load increments of one run."""

    def __init__(self, equations: ImplicitEquations, state: State, tolerance: float, iterations: int) -> None:
        self.equations, self.state = equations, state
        self.external: Floats = np.zeros((len(equations.reference), 2))
        self.contact_forces = ContactForces(equations)
        self.time = 0.0
        self.iteration = NewtonIteration(equations, state, self, tolerance, iterations)
        self.iteration.system.loose = FreeMotions(equations.reference, equations.prescribed.dof)
        self.ledger = Ledger(state)
        self.prediction = Prediction(equations, state) if "moved" in state else None
        self.relaxation: Relaxation | None = None

    def of_stresses(self, diagonal: Floats) -> Floats:
        """Return the part of the `diagonal` (N, 2) [N/mm] of `stiffness` by stresses: all, as there are no masses."""
        return diagonal

    def solve(self, dt: float) -> Outcome:
        """Advance the state by dt of (pseudo-)time; the state is undefined on failure."""
        equations, state = self.equations, self.state
        before = state["displacement"].copy()
        outcome = self._relax(dt) if equations.stabilised else self._iterate(dt)
        if not outcome.reason:
            outcome.motion = state["displacement"] - before
            if self.prediction is not None:
                # a jump is not extrapolated
                self.prediction.moved[:] = 0.0 if equations.stabilised else outcome.motion
        return outcome

    def _iterate(self, dt: float) -> Outcome:
        equations = self.equations
        equations.begin_step(dt)
        self.start(dt)
        self.time = self.state.time + dt
        prescribed = equations.prescribed
        target = prescribed.scale * prescribed.values(self.time)[prescribed.ramp]
        expected, limited = equations.estimate(self.time), None
        if expected is not None:
            self._begin_at(expected, dt, target)
        elif self.prediction is not None and self.prediction.start(dt, target, self._reachable):
            limited = LIMITED if self.prediction.flows else None
        outcome = self.iteration.run(dt, target, limited)
        if not outcome.reason:
            self.accept()
        return outcome

    def _relax(self, dt: float) -> Outcome:
        """Iterate through states slowed by viscous forces; see `Relaxation`."""
        if self.relaxation is None:
            self.relaxation = Relaxation(self.equations, self.state)
        try:
            return self.relaxation.solve(self, dt)
        finally:
            self.relaxation.active = False

    def start(self, dt: float, loaded: float | None = None) -> None:
        """Set forces at the start of the step, for the energy balance; `loaded`: the time [s] of earlier loads."""
        state = self.state
        self.time = state.time if loaded is None else loaded
        # time-dependent laws have their old stress there
        timed = bool(getattr(self.equations, "needs", ()))
        self.equations.internal_force(0.0 if timed else dt)
        if self.equations.contact is not None:
            self.equations.contact.evaluate(self.equations.position)
        out = np.zeros_like(self.external)
        self.unbalanced(out)
        out.reshape(-1)[self.equations.prescribed.dof] = 0.0
        # a load that nothing carries yet grows during the step: its work follows a load path in balance
        carried = self.external - out if loaded is None else self.external
        self.ledger.begin_step(carried, self.contact_forces.normal, self.contact_forces.tangential)
        if timed:
            self.equations.internal_force(dt)

    def _begin_at(self, expected: Estimate, dt: float, target: Floats) -> None:
        """Start the iteration at an expected state, unless cells fold over there."""
        equations, contact, displacement = self.equations, self.equations.contact, self.state["displacement"]
        before = displacement.copy()
        displacement[:] = expected.displacement
        displacement.reshape(-1)[equations.prescribed.dof] = target
        if not self._reachable(before):
            displacement[:] = before
            return
        equations.internal_force(dt)
        if equations.folded() or not np.isfinite(self.state["internal_force"]).all():
            displacement[:] = before
        elif contact is not None:
            contact.evaluate(equations.position)
            conditions, y = contact.conditions, self.iteration.trial.multipliers
            np.multiply(expected.pressure, conditions.measure, out=y)
            y[:, ~conditions.present] = 0.0

    def _reachable(self, before: Floats) -> bool:
        """Return whether potentials allow the motion from the displacement `before` (N, 2) [mm] to the present one."""
        contact, now = self.equations.contact, self.state["displacement"]
        if contact is None or not contact.by_energy:
            return True
        return contact.free_share(self.equations.reference + before, now - before, np.inf) == 1.0

    def accept(self) -> None:
        """Book the step, and accept the trial as state."""
        state, contact, own = self.state, self.equations.contact, self.contact_forces
        rubbed = 0.0, 0.0
        if contact is not None:
            state["contact_force"][:] = own.total()
            rubbed = contact.friction_along_the_way()
        held = self.equations.prescribed.dof
        reaction = state["reaction"].reshape(-1)
        reaction[:] = 0.0
        forces = self.external + (state["contact_force"] if contact is not None else 0.0)
        reaction[held] = (state["internal_force"] - forces).reshape(-1)[held]
        self.ledger.end(self.external, own.normal, own.tangential, rubbed)
        self.equations.accept()

    # --- called by the iteration ------------------------------------------------------------------

    def update_stresses(self, dt: float) -> None:
        """Compute stresses at the end of the step."""
        self.equations.internal_force(dt)

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill external and contact forces minus internal forces."""
        self.equations.external_force(self.time, self.external)
        np.subtract(self.external, self.state["internal_force"], out=out)
        self.contact_forces.add_to(out)
        if self.relaxation is not None and self.relaxation.active:
            out += self.relaxation.force()
        return self.external, self.state["internal_force"], self.contact_forces.normal

    def stiffness(self, dt: float) -> Any:
        """Return the stiffness of the bodies and of follower loads."""
        matrix = self.equations.stiffness(dt)
        self.equations.add_load_stiffness(self.time, matrix, 1.0, 0.0)
        if self.relaxation is not None and self.relaxation.active:
            return with_diagonal(matrix, 1.0, self.relaxation.viscosity.reshape(-1))
        return matrix


class Ledger:
    """Books the work of every kind of force over a step by the trapezoidal rule, exact for forces linear in motion.

    If surfaces begin to slide within a step, friction takes more: this excess is booked as work of loads, too.
    """

    def __init__(self, state: State) -> None:
        self.state = state
        self.before: list[Floats] = []

    def begin_step(self, external: Floats, normal: Floats, tangential: Floats) -> None:
        """Save forces and positions at the start."""
        state = self.state
        self.displacement = state["displacement"].copy()
        self.before = [state[name].copy() for name in ("internal_force", "reaction")] + [
            external.copy(),
            normal.copy(),
            tangential.copy(),
        ]

    def end(self, external: Floats, normal: Floats, tangential: Floats, slid: tuple[float, float]) -> None:
        """Book the step from there to the present state; `slid` is the result of `friction_along_the_way`."""
        state, work = self.state, self.state["work"]
        moved = state["displacement"] - self.displacement
        internal, reaction, loads, pressed, rubbed = self.before
        work[INTERNAL] += _work(internal, state["internal_force"], moved)
        work[EXTERNAL] += _work(reaction, state["reaction"], moved) + _work(loads, external, moved)
        work[CONTACT] += _work(pressed, normal, moved)
        if len(tangential):
            work[FRICTION] += _work(rubbed, tangential, moved)
        taken, excess = slid
        work[SLIP] += taken
        work[FRICTION] -= excess
        work[EXTERNAL] += excess


def _work(before: Floats, after: Floats, moved: Floats) -> float:
    return float(0.5 * np.vdot(before + after, moved))


class Prediction:
    """Start of the iteration of a load increment: with a history, bodies continue their motion of the step before.

    At the start of a step the stiffness of a law with history is elastic. A correction by it loads contact many times
    more than the step will, and most of the iterations are spent on constraints that it opened and closed wrongly.
    Continued strains make the law flow from the first iteration on (de Souza Neto, Peric & Owen 2008, 4.4).
    With friction contact finds its stick zones a little sooner. Without both, steps are long, and the motion of the
    step before opens and closes more than it saves. Works on the state's displacement in place.

    moved    (N, 2) [mm] motion of the last step, kept in the state
    flows    True if a law has a history
    follows  True if steps continue the step before: bodies flow, or there is friction
    """

    def __init__(self, equations: ImplicitEquations, state: State) -> None:
        self.equations, self.state = equations, state
        self.moved = state["moved"]
        self.flows = any(name.startswith("history.") for name in state.fields)
        self.follows = self.flows or (equations.contact is not None and len(equations.contact.conditions.slip) > 0)
        self.load: Floats = np.zeros_like(self.moved)

    def start(self, dt: float, target: Floats, reachable: Callable[[Floats], bool] = lambda before: True) -> bool:
        """Extrapolate to the end of a step of length dt [s] with prescribed displacements `target` (p,) [mm].

        `reachable` returns whether the state may go there directly from a displacement (N, 2) [mm].

        Returns False if the state is unchanged: no flow, no step before, or loading that turns.
        """
        ratio = self._ratio(dt, target) if self.follows and self.state.last_dt else 0.0
        if not 0.0 < ratio <= FARTHEST:
            return False
        u = self.state["displacement"]
        before = u.copy()
        u += ratio * self.moved
        u.reshape(-1)[self.equations.prescribed.dof] = target
        if not reachable(before):
            u[:] = before
            return False
        self.equations.internal_force(dt)
        if self.equations.folded():
            u[:] = before
            return False
        return True

    def _ratio(self, dt: float, target: Floats) -> float:
        """Return the ratio of the step to the last step: by prescribed motion, or by loads if nothing is moved."""
        held = self.equations.prescribed.dof
        ahead = target - self.state["displacement"].reshape(-1)[held]
        ratio = _along(ahead, self.moved.reshape(-1)[held])
        if ratio is not None:
            return ratio
        now = self.state.time
        before, at, after = (self._load(time) for time in (now - self.state.last_dt, now, now + dt))
        return _along((after - at).ravel(), (at - before).ravel()) or 0.0

    def _load(self, time: float) -> Floats:
        self.load[:] = 0.0
        self.equations.external_force(time, self.load)
        return self.load.copy()


def _along(ahead: Floats, behind: Floats) -> float | None:
    """Return the ratio of `ahead` to `behind`; 0 if their directions differ, None without any."""
    size = float(behind @ behind)
    if size == 0.0:
        return None
    along = float(ahead @ behind)
    return along / size if along > ALONG * float(np.sqrt(size * (ahead @ ahead))) else 0.0
