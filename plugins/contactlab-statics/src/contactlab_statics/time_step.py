"""One implicit step in time by the midpoint rule (docs/statics.md).

    M (v+ - v)/dt + alpha M (v + v+)/2 + f(u + (1/2 + x) (u+ - u)) = (e + e+)/2 + G^T y,   u+ - u = dt (v + v+)/2

with gaps complementary to y at the end of the step; then impulses make the velocities fit the contacts (impulses.py).
Stresses in the middle (x = 0) have no moment about the mean positions, so that angular momentum is kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import WORK, Floats, ImplicitEquations, State, Step, StepStatus
from contactlab_statics.contact_forces import ContactForces
from contactlab_statics.factor import with_diagonal
from contactlab_statics.impacts import Impacts, impacts_of
from contactlab_statics.impulses import solve_impulses
from contactlab_statics.iteration import NewtonIteration, take_back

MEET = "surfaces meet within it at a speed that matters"
FRONTS = "contact changes faster than it can follow"
INTERNAL, EXTERNAL, DAMPING, CONTACT, FRICTION, NUMERICAL, SLIP = range(len(WORK))


class StepStart:
    """Displacements, velocities and loads (N, 2) at the start of a step."""

    def __init__(self, nodes: int) -> None:
        self.u, self.v, self.load = (np.zeros((nodes, 2)) for _ in range(3))

    def take(self, state: State, equations: ImplicitEquations) -> None:
        """The state as it is is the start of a step."""
        self.u[:], self.v[:] = state["displacement"], state["velocity"]
        equations.external_force(state.time, self.load)


class TimeStep:
    """Makes steps in time. Implements `Balance` for dynamics.

    share    of the way through a step at which stresses are taken: 1/2, or more for a viscosity
    impacts  judge steps in which surfaces meet; None if there are none, or if they are not to be cut
    """

    def __init__(
        self,
        equations: ImplicitEquations,
        state: State,
        tolerance: float,
        iterations: int,
        dissipation: float,
        cuts: bool,
    ) -> None:
        self.equations, self.state, self.share = equations, state, 0.5 + dissipation
        nodes = len(equations.reference)
        self.u, self.v = state["displacement"], state["velocity"]
        self.drift = state["drift"] if "drift" in state else np.zeros_like(self.v)
        self.start, self.contact_forces = StepStart(nodes), ContactForces(equations)
        self.load, self.inertia, self.stopping = (np.zeros((nodes, 2)) for _ in range(3))
        self.time = self.dt = self.damping = 0.0
        self.mass: Floats = np.repeat(equations.mass, 2).reshape(-1, 2)
        self.held = equations.prescribed.dof
        mobility = np.divide(1.0, self.mass, out=np.zeros_like(self.mass), where=self.mass > 0.0)
        mobility.reshape(-1)[self.held] = 0.0
        self.mobility = mobility
        self.iteration = NewtonIteration(equations, state, self, tolerance, iterations)
        self.impacts = Impacts(state, self.mass, mobility) if cuts and impacts_of(equations) else None

    def step(self, dt: float) -> Step:
        """Advance the state by dt, or restore it."""
        equations, state = self.equations, self.state
        start = state.snapshot()
        self._start(dt)
        prescribed = equations.prescribed
        outcome = self.iteration.run(dt, prescribed.scale * prescribed.values(self.time)[prescribed.ramp])
        trace = tuple(outcome.trace)
        reason, longest = outcome.reason, None
        if not reason and self.impacts is not None:
            longest = self.impacts.met(self.contact_forces.normal, self.start.v, self.u - self.start.u)
            reason = MEET if longest is not None else ""
        reason = reason or self._end()
        if not reason and self.impacts is not None:
            longest, repeat = self.impacts.limit(self.of_stresses(self.iteration.stiffness.diagonal().reshape(-1, 2)))
            reason = FRONTS if repeat else ""
        if reason:
            take_back(equations, state, start)
            return Step(
                status=StepStatus.not_converged, iterations=len(trace), residual=outcome.residual.largest,
                reason=reason, trace=trace, longest=longest,
            )  # fmt: skip
        equations.accept()
        return Step(
            state["work"], state["reaction"], iterations=len(trace), residual=outcome.residual.contact, trace=trace,
            longest=longest,
        )  # fmt: skip

    def _start(self, dt: float) -> None:
        equations, state = self.equations, self.state
        equations.begin_step(dt)
        self.start.take(state, equations)
        self.time, self.dt = state.time + dt, dt
        if self.impacts is not None:
            self.impacts.begin(dt)
        # the drift is that of the start, and follows until the middle of the step
        following = 0.5 * dt / equations.relaxation if equations.relaxation else 0.0
        self.damping = equations.damping / (1.0 + following)
        # what would stop all nodes within the step: forces far below it change no velocity
        self.stopping = self.mass * self.v / dt

    # --- Balance --------------------------------------------------------------------------------

    def update_stresses(self, dt: float) -> None:
        """Those in the middle of the step, or after it where they lead."""
        self.equations.internal_force(self.share * dt, self.share)

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Mean external, contact and damping forces minus internal ones and the rate of momentum."""
        self._update_velocities()
        self._impressed(out)
        np.multiply(self.mass, (self.v - self.start.v) / self.dt, out=self.inertia)
        out -= self.inertia
        if self.damping:
            out -= self.damping * self.mass * (0.5 * (self.start.v + self.v) - self.drift)
        internal, start, normal = self.state["internal_force"], self.start, self.contact_forces.normal
        return self.load, start.load, internal, normal, self.inertia, self.stopping

    def _update_velocities(self) -> None:
        """Velocities that lead to the trial displacements; prescribed ones are those of the step."""
        moved = (self.u - self.start.u) / self.dt
        np.subtract(2.0 * moved, self.start.v, out=self.v)
        self.v.reshape(-1)[self.held] = moved.reshape(-1)[self.held]

    def _impressed(self, out: Floats) -> None:
        """External and contact forces minus internal ones, over the step."""
        np.negative(self.state["internal_force"], out=out)
        if self.equations.external_force(self.time, self.load):
            out += 0.5 * (self.start.load + self.load)
        self.contact_forces.add_to(out)

    def stiffness(self, dt: float) -> Any:
        """Of stresses, mean loads and inertia."""
        inertia = (2.0 / dt + self.damping) / dt * self.mass.reshape(-1)
        matrix = with_diagonal(self.equations.stiffness(self.share * dt), self.share, inertia)
        self.equations.add_load_stiffness(self.time, matrix, 0.5, 2.0 / dt)
        return matrix

    def of_stresses(self, diagonal: Floats) -> Floats:
        """See `Balance`."""
        return (diagonal - (2.0 / self.dt + self.damping) / self.dt * self.mass) / self.share

    # --- the end of a step ----------------------------------------------------------------------

    def _end(self) -> str:
        """Velocities, books, and stresses and histories at the end; the reason where that makes no sense, or ""."""
        self._book()
        self.equations.internal_force(self.dt)
        if self.equations.folded() or not np.isfinite(self.state["internal_force"]).all():
            return "cells fold over at the end of the step"
        return ""

    def _book(self) -> None:
        """Velocities from momentum, so that it is kept to round-off whatever the tolerance; works of all forces."""
        state, contact, dt = self.state, self.equations.contact, self.dt
        alpha, impressed = 0.5 * self.damping * dt, np.zeros_like(self.u)
        self._update_velocities()
        self._impressed(impressed)
        damped = (1.0 - alpha) * self.start.v + 2.0 * alpha * self.drift
        free = (damped + dt * self.mobility * impressed) / (1.0 + alpha)
        np.copyto(self.v, free, where=self.mobility > 0.0)
        self._support(impressed)
        moved = self.u - self.start.u
        work = state["work"]
        work[INTERNAL] += self._internal_work(moved)
        work[EXTERNAL] += 0.5 * np.vdot(self.start.load + self.load, moved)
        beside = 0.5 * (self.start.v + self.v) - self.drift
        work[DAMPING] += self.damping * np.vdot(self.mass * beside, moved)
        if self.equations.relaxation:
            self.drift += dt / (self.equations.relaxation + 0.5 * dt) * (moved / dt - self.drift)
        if contact is not None:
            self._book_contact(moved)

    def _internal_work(self, moved: Floats) -> float:
        """That of stresses in the middle; what they lead by is numerical viscosity, and booked as such."""
        internal = self.state["internal_force"]
        whole = float(np.vdot(internal, moved))
        if self.share == 0.5:
            return whole
        self.equations.internal_force(0.5 * self.dt, 0.5)
        middle = float(np.vdot(internal, moved))
        self.state["work"][NUMERICAL] += whole - middle
        return middle

    def _support(self, impressed: Floats) -> None:
        """Mean reactions, and their work: what the prescribed nodes gain and pass on."""
        held, state = self.held, self.state
        mass, before, after, drift = (a.reshape(-1)[held] for a in (self.mass, self.start.v, self.v, self.drift))
        moved = (self.u - self.start.u).reshape(-1)[held]
        passed = self.damping * mass * (0.5 * (before + after) - drift) - impressed.reshape(-1)[held]
        reaction = state["reaction"].reshape(-1)
        reaction[:] = 0.0
        reaction[held] = mass * (after - before) / self.dt + passed
        state["work"][EXTERNAL] += float(0.5 * mass @ (after**2 - before**2) + passed @ moved)

    def _book_contact(self, moved: Floats) -> None:
        """Velocities that fit the contacts; contact forces with their impulses, and their work."""
        state, contact, work = self.state, self.equations.contact, self.state["work"]
        normal, tangential = self.contact_forces.normal, self.contact_forces.tangential
        assert contact is not None
        found = solve_impulses(contact, self.iteration.trial.response, self.mobility, self.v)
        force = state["contact_force"]
        force[:] = normal + found.nodal / self.dt
        work[CONTACT] += np.vdot(normal, moved) + found.lost
        if len(tangential):
            force += tangential
            work[FRICTION] += np.vdot(tangential, moved) + found.rubbed
            work[SLIP] += contact.dissipation()
        contact.conditions.force += found.each / self.dt
        # what the impulses push on prescribed nodes, their supports hold
        held = self.held
        impulse = found.nodal.reshape(-1)[held]
        state["reaction"].reshape(-1)[held] -= impulse / self.dt
        work[EXTERNAL] -= float(impulse @ self.v.reshape(-1)[held])
