"""An implicit step in time, of any scheme whose velocities and accelerations are affine in the motion d of the step.

    M a(d) + alpha M v_s + f(u + (s + x) d) = e_s + G^T y,   v_s, e_s at the share s of the step

with gaps complementary to y at the end of the step. Contact forces act evenly over it: they add dt^2/2 c to the motion
and dt c to velocities, c = M^-1 G^T y, and the scheme applies to the rest of the motion, a(d - dt^2/2 c) (Deuflhard,
Krause & Ertel 2008). The balance is linear in y and divided by its weight of y, which is 1 in the midpoint rule. Then
impulses make the velocities fit the contacts (`solve_impulses`). Stresses in the middle (s + x = 1/2) have no moment
about the mean positions, so that angular momentum is kept.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contactlab.api import WORK, Floats, ImplicitContact, ImplicitEquations, Response, State
from contactlab.api.frame import STICK
from contactlab.api.motion import OfMotion
from contactlab.implicit.factor import with_diagonal
from contactlab.implicit.impacts import Impacts, impacts_of
from contactlab.implicit.iteration import NewtonIteration, Outcome
from contactlab.implicit.sparse import combined, diagonal, picked, product, scaled, stacked, total, transposed
from contactlab.implicit.trial import Balance, ContactForces

MEET = "surfaces meet within it at a speed that matters"
FRONTS = "contact changes faster than it can follow"
INTERNAL, EXTERNAL, DAMPING, CONTACT, FRICTION, NUMERICAL, SLIP = range(len(WORK))
ROUND_OFF = 1e-12  # of the kinetic energy: rounding of differences of its terms
DIGITS = 12  # of rates and weights: a weight of contact forces that differs from 1 by round-off is 1


class Scheme(NamedTuple):
    """Arguments of `contactlab.api.ImplicitMotion.solve`, and the rates of velocity [1/s] and acceleration [1/s^2]."""

    velocity: OfMotion
    acceleration: OfMotion
    at: float
    lead: float
    rate: float
    inertia: float


class StepStart:
    """Displacements, velocities and loads (N, 2) at the start of a step."""

    def __init__(self, nodes: int) -> None:
        self.u, self.v, self.load = (np.zeros((nodes, 2)) for _ in range(3))

    def take(self, state: State, equations: ImplicitEquations) -> None:
        """Take the present state as the start of a step."""
        self.u[:], self.v[:] = state["displacement"], state["velocity"]
        equations.external_force(state.time, self.load)


class TimeStep(Balance):
    """Makes steps in time.

    share       point of the step at which stresses are taken
    resistance  [1/s^2] derivative of forces of inertia and damping by the motion, over the mass
    weight      of contact forces in the balance
    impacts     judge steps in which surfaces meet; None without them, or if they are not to be cut
    """

    def __init__(self, equations: ImplicitEquations, state: State, tolerance: float, iterations: int) -> None:
        self.equations, self.state = equations, state
        nodes = len(equations.reference)
        self.u, self.v = state["displacement"], state["velocity"]
        self.drift = state["drift"] if "drift" in state else np.zeros_like(self.v)
        self.start, self.contact_forces = StepStart(nodes), ContactForces(equations)
        self.load, self.inertia, self.stopping = (np.zeros((nodes, 2)) for _ in range(3))
        self.time = self.dt = self.damping = self.share = self.resistance = 0.0
        self.weight = 1.0
        self.mass: Floats = np.repeat(equations.mass, 2).reshape(-1, 2)
        self.held = equations.prescribed.dof
        mobility = np.divide(1.0, self.mass, out=np.zeros_like(self.mass), where=self.mass > 0.0)
        mobility.reshape(-1)[self.held] = 0.0
        self.mobility = mobility
        self.iteration = NewtonIteration(equations, state, self, tolerance, iterations)
        self.impacts = Impacts(state, self.mass, mobility) if "impact" in state and impacts_of(equations) else None

    def solve(self, dt: float, scheme: Scheme) -> Outcome:
        """Advance the state by dt; the state is undefined on failure."""
        self._start(dt, scheme)
        prescribed, impacts = self.equations.prescribed, self.impacts
        outcome = self.iteration.run(dt, prescribed.scale * prescribed.values(self.time)[prescribed.ramp])
        if not outcome.reason and impacts is not None:
            outcome.longest = impacts.met(self.contact_forces.normal, self.start.v, self.u - self.start.u)
            outcome.reason = MEET if outcome.longest is not None else ""
        outcome.reason = outcome.reason or self._end(outcome)
        if not outcome.reason and impacts is not None:
            diagonal = self.of_stresses(self.iteration.stiffness.diagonal().reshape(-1, 2))
            outcome.longest, repeat = impacts.limit(diagonal)
            outcome.reason = FRONTS if repeat else ""
        if not outcome.reason:
            self.equations.accept()
        return outcome

    def acceleration(self) -> Floats:
        """Return accelerations (N, 2) [mm/s^2] by stresses, loads and damping of this moment."""
        load = np.zeros_like(self.load)
        self.equations.internal_force(0.0)
        self.equations.external_force(self.state.time, load)
        damped = self.equations.damping * self.mass * (self.v - self.drift)
        return np.asarray(self.mobility * (load - self.state["internal_force"] - damped))

    def _start(self, dt: float, scheme: Scheme) -> None:
        equations, state = self.equations, self.state
        equations.begin_step(dt)
        self.start.take(state, equations)
        self.time, self.dt, self.scheme, self.share = state.time + dt, dt, scheme, scheme.at + scheme.lead
        if self.impacts is not None:
            self.impacts.begin(dt)
        # the drift starts at its old value, and follows until the middle of the step
        following = 0.5 * dt / equations.relaxation if equations.relaxation else 0.0
        self.damping = equations.damping / (1.0 + following)
        # forces that would stop all nodes within the step: forces far below change no velocity
        self.stopping = self.mass * self.v / dt
        self.resistance = scheme.inertia + scheme.at * self.damping * scheme.rate
        self.weight = round(0.5 * dt**2 * scheme.inertia, DIGITS)

    # --- called by the iteration ------------------------------------------------------------------

    def update_stresses(self, dt: float) -> None:
        """Compute stresses in the middle of the step, or later by the scheme's `lead`."""
        self.equations.internal_force(self.share * dt, self.share)

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill external, contact and damping forces minus internal forces and the rate of momentum, over `weight`."""
        moved = self._update_velocities()
        self._impressed(out, self.weight)
        np.multiply(self.mass, self.scheme.acceleration(moved), out=self.inertia)
        # held nodes move at the mean velocity of the step
        gained = (self.v - self.start.v).reshape(-1)[self.held] / self.dt
        self.inertia.reshape(-1)[self.held] = self.mass.reshape(-1)[self.held] * gained
        out -= self.inertia
        if self.damping:
            out -= self._damped()
        out /= self.weight
        internal, start, normal = self.state["internal_force"], self.start, self.contact_forces.normal
        return self.load, start.load, internal, normal, self.inertia, self.stopping

    def _update_velocities(self) -> Floats:
        """Update velocities to the trial displacements, prescribed velocities to the step. Return the motion.

        The contribution of contact beyond the scheme waits until the end: neither loads nor damping include it.
        """
        moved = self.u - self.start.u
        self.v[:] = self.scheme.velocity(moved)
        self.v.reshape(-1)[self.held] = moved.reshape(-1)[self.held] / self.dt
        return moved

    def _damped(self) -> Floats:
        """Return damping forces (N, 2) [N]."""
        return np.asarray(self.damping * self.mass * (self._at(self.start.v, self.v) - self.drift))

    def _at(self, start: Floats, end: Floats) -> Floats:
        """Return values (N, 2) at the share of the step at which forces balance."""
        return (1.0 - self.scheme.at) * start + self.scheme.at * end

    def _impressed(self, out: Floats, weight: float) -> None:
        """Fill external forces, contact forces times a weight, minus internal forces."""
        np.negative(self.state["internal_force"], out=out)
        if self.equations.external_force(self.time, self.load):
            out += self._at(self.start.load, self.load)
        self.contact_forces.add_to(out, weight)

    def stiffness(self, dt: float) -> Any:
        """Return the stiffness of stresses, loads, damping and inertia, over `weight`."""
        resistance = self.resistance / self.weight * self.mass.reshape(-1)
        matrix = with_diagonal(self.equations.stiffness(self.share * dt), self.share / self.weight, resistance)
        self.equations.add_load_stiffness(self.time, matrix, self.scheme.at / self.weight, self.scheme.rate)
        return matrix

    def of_stresses(self, diagonal: Floats) -> Floats:
        """Return the part of the `diagonal` (N, 2) [N/mm] of `stiffness` by stresses."""
        return (self.weight * diagonal - self.resistance * self.mass) / self.share

    # --- the end of a step ----------------------------------------------------------------------

    def _end(self, outcome: Outcome) -> str:
        """Compute velocities, works, stresses and histories at the end. Return a reason if they are invalid, or ""."""
        outcome.motion = self._book()
        self.equations.internal_force(self.dt)
        if self.equations.folded() or not np.isfinite(self.state["internal_force"]).all():
            return "cells fold over at the end of the step"
        return ""

    def _book(self) -> Floats:
        """Compute velocities from momentum, conserved to round-off at any tolerance, and works of all forces."""
        state, dt, impressed = self.state, self.dt, np.zeros_like(self.u)
        moved = self._update_velocities()
        self._impressed(impressed, 1.0)
        pressed = self.contact_forces.total()
        # the motion that balances all forces, and the motion without contact
        balanced = moved + self.mobility * (self.weight / self.resistance * self.iteration.trial.force)
        scheme = balanced - 0.5 * dt**2 * self.mobility * pressed
        np.copyto(self.v, self.scheme.velocity(balanced), where=self.mobility > 0.0)
        damped = self._damped()
        self.v += dt * round(1.0 - 0.5 * dt * self.scheme.rate, DIGITS) * self.mobility * pressed
        self._support(damped - impressed)
        work = state["work"]
        work[NUMERICAL] += self._lost(scheme, balanced, pressed)
        work[INTERNAL] += self._internal_work(moved)
        work[EXTERNAL] += np.vdot(self._at(self.start.load, self.load), moved)
        work[DAMPING] += np.vdot(damped, moved)
        if self.equations.relaxation:
            self.drift += dt / (self.equations.relaxation + 0.5 * dt) * (moved / dt - self.drift)
        if self.equations.contact is not None:
            self._book_contact(moved)
        return scheme

    def _lost(self, scheme: Floats, balanced: Floats, pressed: Floats) -> float:
        """Return the work [mJ] of inertial forces that does not become kinetic energy: of the scheme itself."""
        free = self.mobility > 0.0
        spent = np.vdot(self.mass * self.scheme.acceleration(scheme) + pressed, np.where(free, balanced, 0.0))
        kinetic = 0.5 * self.mass * free
        after, before = (float(np.vdot(kinetic * v, v)) for v in (self.v, self.start.v))
        lost = float(spent) - (after - before)
        return lost if abs(lost) > ROUND_OFF * (after + before) else 0.0

    def _internal_work(self, moved: Floats) -> float:
        """Return the work of mid-step stresses; the excess by their lead is booked as numerical viscosity."""
        internal = self.state["internal_force"]
        whole = float(np.vdot(internal, moved))
        if self.share == 0.5:
            return whole
        self.equations.internal_force(0.5 * self.dt, 0.5)
        middle = float(np.vdot(internal, moved))
        self.state["work"][NUMERICAL] += whole - middle
        return middle

    def _support(self, passed: Floats) -> None:
        """Compute mean reactions, and their work: gains of prescribed nodes and passed forces (N, 2) [N]."""
        held, state = self.held, self.state
        mass, before, after = (a.reshape(-1)[held] for a in (self.mass, self.start.v, self.v))
        moved, passed = (self.u - self.start.u).reshape(-1)[held], passed.reshape(-1)[held]
        reaction = state["reaction"].reshape(-1)
        reaction[:] = 0.0
        reaction[held] = mass * (after - before) / self.dt + passed
        state["work"][EXTERNAL] += float(0.5 * mass @ (after**2 - before**2) + passed @ moved)

    def _book_contact(self, moved: Floats) -> None:
        """Compute velocities that fit the contacts, contact forces with their impulses, and their work."""
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
            work[SLIP] += contact.dissipation() - found.rubbed
        multipliers = self.iteration.trial.multipliers
        multipliers += found.each / self.dt
        # supports hold the impulses on prescribed nodes
        held = self.held
        impulse = found.nodal.reshape(-1)[held]
        state["reaction"].reshape(-1)[held] -= impulse / self.dt
        work[EXTERNAL] -= float(impulse @ self.v.reshape(-1)[held])


class Impulses(NamedTuple):
    """Impulses [N s] on the nodes (N, 2) and in each constraint (r, k), and their works [mJ].

    Prescribed motion of other nodes counts as well. `lost` is the work of normal impulses and of impulses in stick,
    `rubbed` the work of friction on surfaces that slip.
    """

    nodal: Floats
    each: Floats
    lost: float
    rubbed: float


def solve_impulses(contact: ImplicitContact, response: Response, mobility: Floats, velocity: Floats) -> Impulses:
    """Change `velocity` (N, 2) in place by impulses: closed surfaces then neither separate nor approach.

    A gap that multipliers or stiff springs hold at the end of a step says nothing about velocities there: the midpoint
    rule would let them oscillate about the right ones for ever. Impulses z with

        v = v* + M^-1 (G^T z + T^T C z),   G v = 0

    over all closed constraints G (and the tangential rows of constraints in stick) are the projection of v* in the
    metric kinetic energy, which can only fall without friction: 1/2 z . G (v* + v) = -1/2 z . G M^-1 G^T z. Surfaces
    that slip (tangential rows T) have friction C z in addition to a normal impulse, C = -mu times the sense of the
    slip: in the step when surfaces meet the midpoint rule needs twice the force that stops them; z removes half of it,
    and friction with it.

    `mobility` (N, 2) is the inverse mass. Springs that are softer than their nodes, with the inertia
    over the step, stop surfaces gradually and return the stored energy; stiffer springs hold gaps like multipliers.
    """
    force, enforcement = contact.conditions.force, contact.enforcement
    closed = contact.conditions.present & (force[0] > 0.0)
    if not (enforcement.exact or enforcement.augments):
        nodes = np.where(closed, contact.conditions.stiffness, 0.0)
        closed &= response.by_force[0] * nodes <= response.by_gap[0]
    if not closed.any():
        return Impulses(np.zeros_like(velocity), np.zeros_like(force), 0.0, 0.0)
    normal, tangent = contact.directions(np.flatnonzero(closed).astype(np.int32))
    stick, ratio = np.zeros(0, np.int64), np.zeros(0)
    if len(force) > 1:
        stick = np.flatnonzero(response.status[closed] == STICK)
        ratio = np.where(response.status[closed] == STICK, 0.0, np.sign(force[1, closed]))
        ratio *= contact.conditions.bound[0, closed]
    sticking = [picked(tangent, stick)] if len(stick) else []
    rubbing = scaled(tangent, ratio) if ratio.any() else scaled(normal, np.zeros(normal.shape[0]))
    held, acting = stacked([normal, *sticking]), stacked([total(normal, rubbing), *sticking])
    speed, sliding = held @ velocity.reshape(-1), rubbing @ velocity.reshape(-1)
    flexible = product(product(held, diagonal(mobility.reshape(-1))), transposed(acting))
    # redundant constraints share their impulse
    impulse = -np.linalg.lstsq(flexible.toarray(), speed, rcond=1e-12)[0]
    each, count = np.zeros_like(force), normal.shape[0]
    each[0, closed] = impulse[:count]
    if len(force) > 1:
        each[1, closed] = ratio * impulse[:count]
        each[1, np.flatnonzero(closed)[stick]] = impulse[count:]
    nodal = combined(acting, impulse).reshape(velocity.shape)
    velocity += mobility * nodal
    lost = 0.5 * float(impulse @ (speed + held @ velocity.reshape(-1)))
    rubbed = 0.5 * float(impulse[:count] @ (sliding + rubbing @ velocity.reshape(-1)))
    return Impulses(nodal, each, lost, rubbed)
