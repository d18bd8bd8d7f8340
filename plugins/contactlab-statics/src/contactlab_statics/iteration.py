"""Newton's iteration for one step: the same for load steps and steps in time."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from contactlab.api import Floats, ImplicitEquations, Iteration, Response, State
from contactlab_statics.convergence import Residual, contact_residual, force_scale
from contactlab_statics.factor import SingularSystem
from contactlab_statics.saddle import SaddleSystem

DEEPEST = 1.0  # segment lengths that a correction may push a surface into the other
AUGMENTATIONS = 40  # times the iterations of a step that taking over forces may need
CAREFUL = (1.0, 0.5, 0.25, 0.125)  # fractions tried once statuses go round in circles
SHORTEST = 1.0 / 64.0  # of a correction: below it the step is given up
FALLING, FALL = 6, 0.9  # residuals in a row, each below that of the one before: then more iterations are made
MORE = 4  # times the wished iterations, at most
AWAY = 100.0  # times the size of the model: a correction that large means that nothing holds a body
TOUCHING = 1e-9  # segment lengths
FLOOR = 1e-10  # of the stiffest node's force at one unit of displacement per cell: nothing is loaded yet
ROUND_OFF = 8.0 * float(np.finfo(float).eps)  # of the force of the largest displacement or position: nothing is exacter


class Balance(Protocol):
    """What is in balance at the end of a step.

    dynamic  whether `stiffness` holds that of masses, which says nothing of the round-off of stresses
    """

    dynamic: bool

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill `out` (N, 2) with external and contact forces minus all others; returns the forces by kind."""

    def stiffness(self, dt: float) -> Any:
        """Derivative of minus the unbalanced forces without contact, (2N, 2N) CSC."""


@dataclass
class Outcome:
    """How the iteration of a step ended; `reason` is empty if it converged."""

    reason: str = ""
    residual: Residual = field(default_factory=lambda: Residual(0.0, 0.0))
    trace: list[Iteration] = field(default_factory=list)


class NewtonIteration:
    """One run's arrays, bound once. Works on the state's displacement and multipliers in place."""

    def __init__(
        self, equations: ImplicitEquations, state: State, balance: Balance, tolerance: float, most: int
    ) -> None:
        self.equations, self.state, self.balance = equations, state, balance
        self.tolerance, self.most = tolerance, most
        self.contact = equations.contact
        nodes = len(equations.reference)
        self.u = state["displacement"]
        self.held = equations.prescribed.dof
        self.free = np.ones((nodes, 2))
        self.free.reshape(-1)[self.held] = 0.0
        self.system = SaddleSystem(nodes, self.held)
        self.force = np.zeros((nodes, 2))
        multipliers = state["multipliers"] if self.contact is not None else np.zeros((1, 0))
        self.response = Response.allocate(*multipliers.shape)
        self.size = float(np.ptp(equations.reference, axis=0).max())
        self.farthest = float(np.abs(equations.reference).max())
        self.floor = 0.0
        self.round_off: Floats = np.zeros((nodes, 2))
        self.seen: set[bytes] = set()
        self.circling = False

    def run(self, dt: float, target: Floats) -> Outcome:
        """Iterate until the state is in balance with prescribed displacements `target` (p,) [mm]."""
        outcome = Outcome()
        self.system.solver.forget()
        self.floor = 0.0
        self.seen.clear()
        self.circling = False
        self.equations.internal_force(dt)
        given = np.zeros(self.u.size)
        began = 0  # of the iterations since forces were taken over
        while self._goes_on(outcome.trace[began:]):
            self._linearise(dt)
            if not outcome.trace and self._at_rest(target, outcome):
                return outcome
            given[self.held] = target - self.u.reshape(-1)[self.held]
            try:
                left = outcome.residual.largest if outcome.trace else np.inf
                note, length, changed = self._iterate(dt, given, left)
            except SingularSystem as problem:
                outcome.reason = f"the linear system has no solution ({problem}): a body may be held by nothing"
                return outcome
            if length == 0.0:
                outcome.reason = f"no fraction of the correction above {SHORTEST:.3f} can be taken: {note}"
                return outcome
            outcome.residual = residual = self._residual()
            rest = float(np.abs(target - self.u.reshape(-1)[self.held]).max(initial=0.0))
            outcome.trace.append(self._record(residual, changed, length, note))
            if residual.largest <= self.tolerance and rest == 0.0:
                if not self._augment(outcome):
                    return outcome
                began = len(outcome.trace)
            if not np.isfinite(residual.largest):
                outcome.reason = "forces are no longer finite"
                return outcome
        outcome.reason = (
            f"{len(outcome.trace)} iterations left residuals of {residual.force:.1e} (forces) "
            f"and {residual.contact:.1e} (contact)"
        )
        return outcome

    def _at_rest(self, target: Floats, outcome: Outcome) -> bool:
        """Whether the state is in balance as it is: nothing was moved or loaded, and there is nothing to solve."""
        if np.any(target != self.u.reshape(-1)[self.held]):
            return False
        outcome.residual = self._residual()
        return outcome.residual.largest <= self.tolerance and not self._augment(outcome)

    def _goes_on(self, trace: list[Iteration]) -> bool:
        """Whether another iteration is made: up to the wished number, and on while residuals fall all the time."""
        if len(trace) < self.most:
            return True
        left = [max(one.force, one.contact) for one in trace[-FALLING:]]
        fell = len(left) == FALLING and all(new < FALL * old for old, new in pairwise(left))
        return fell and len(trace) < MORE * self.most

    def _augment(self, outcome: Outcome) -> bool:
        """Whether the enforcement wants to go on from the forces it has found; they are its anchor then."""
        contact = self.contact
        if contact is None or not contact.enforcement.augments:
            return False
        conditions = contact.conditions
        left = float(np.abs(conditions.force - conditions.anchor).max(initial=0.0))
        if left <= self.tolerance * max(float(np.abs(conditions.force).max(initial=0.0)), self.floor):
            return False
        conditions.anchor[:] = conditions.force
        self._balance()
        if outcome.trace:
            note = f"forces taken over, which had changed by {left:.1e} N"
            outcome.trace[-1] = outcome.trace[-1]._replace(note=note)
        return len(outcome.trace) < AUGMENTATIONS * self.most

    # --- one iteration --------------------------------------------------------------------------

    def _iterate(self, dt: float, given: Floats, left: float) -> tuple[str, float, int]:
        """Correct the state once; returns what limited the correction, the fraction taken, and status changes.

        left  residual before it
        """
        before = self.response.status.copy()
        du, dy = self._correction(given, left)
        du = du.reshape(self.u.shape)
        note, length = self._careful(dt, du, dy, given) if self.circling else self._move(dt, du, dy, given)
        changed = int(np.count_nonzero(self.response.status != before))
        if changed:
            pattern = self.response.status.tobytes()
            self.circling = self.circling or pattern in self.seen
            self.seen.add(pattern)
        return note, length, changed

    def _correction(self, given: Floats, left: float) -> tuple[Floats, Floats]:
        """Of displacements and multipliers; what is held by nothing but friction is held from its first touch on."""
        try:
            du, dy = self._solved(given, left)
        except SingularSystem:
            if not self._hold():
                raise
        else:
            farthest = float(np.abs(du).max())
            if farthest <= AWAY * self.size or self.size == 0.0:
                return du, dy
            if not self._hold():
                raise SingularSystem(f"it moves nodes by {farthest / self.size:.0e} times the size of the model")
        return self._solved(given, left)

    def _solved(self, given: Floats, left: float) -> tuple[Floats, Floats]:
        return self.system.step(self.stiffness, self.force.reshape(-1), given, self.contact, self.response, left)

    def _hold(self) -> bool:
        """Let surfaces stick that touch without a force yet, as friction has no bound then; whether any do."""
        if self.contact is None or not len(self.contact.conditions.slip):
            return False
        c = self.contact.conditions
        touch = c.present & (c.force[0] == 0.0) & (np.abs(c.gap) <= TOUCHING * c.size)
        c.force[0, touch] = 2.0 * TOUCHING * (c.stiffness * c.size)[touch]
        self._balance()
        return bool(touch.any())

    def _careful(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float]:
        """Statuses go round in circles: of some fractions of the correction take the one that leaves least to do."""
        y = self.contact.conditions.force if self.contact is not None else dy
        start, y_start, found = self.u.copy(), y.copy(), []
        for part in CAREFUL:
            self.u[:], y[:] = start, y_start
            note, length = self._move(dt, part * du, part * dy, given if part == 1.0 else part * given)
            found.append((self._merit(), part * length, part, note))
            if found[-1][0] < found[0][0] and found[-1] > min(found):
                break
        _, length, part, note = min(found)
        if part != found[-1][2]:
            self.u[:], y[:] = start, y_start
            self._move(dt, part * du, part * dy, given if part == 1.0 else part * given)
        return note or ("" if part == 1.0 else "statuses go round in circles"), length

    def _merit(self) -> float:
        """What is left to do [mm^2]: unbalanced forces and conditions, each over its stiffness."""
        rest = float((self.force**2 * self.flexibility**2).sum())
        if self.contact is not None:
            c = self.contact.conditions
            rest += float((self.response.residual[:, c.present] ** 2 / c.stiffness[c.present] ** 2).sum())
        return rest if np.isfinite(rest) else np.inf

    def _move(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float]:
        """Take as much of a correction as keeps cells unfolded and surfaces from passing through each other."""
        start = self.u.copy()
        y = self.contact.conditions.force if self.contact is not None else dy
        y_start = y.copy()
        length, note = self._reach(start, du)
        while length >= SHORTEST:
            self.u[:] = start + length * du
            if length == 1.0:
                self.u.reshape(-1)[self.held] = (start.reshape(-1) + given)[self.held]
            y[:] = y_start + length * dy
            self._evaluate(dt)
            if not self.equations.folded() and np.isfinite(self.force).all():
                return note, length
            length, note = 0.5 * length, "cells fold over"
        return note, 0.0

    def _reach(self, start: Floats, du: Floats) -> tuple[float, str]:
        """Fraction of a correction at which the first condition is pushed too deep."""
        if self.contact is None:
            return 1.0, ""
        conditions, reference = self.contact.conditions, self.equations.reference
        force = conditions.force.copy()
        smallest = float(conditions.size[conditions.present].min(initial=np.inf))
        if not np.isfinite(smallest):
            smallest = self.size / 50.0
        pieces = max(1, int(np.ceil(np.hypot(*du.T).max() / smallest)))
        length, note = 1.0, ""
        for piece in range(1, min(pieces, 64) + 1):
            part = piece / min(pieces, 64)
            self.contact.evaluate(reference + start + part * du)
            depth = np.divide(
                -conditions.gap, conditions.size, out=np.zeros_like(conditions.gap), where=conditions.present
            )
            if depth.max() > DEEPEST:
                length, note = part, "surfaces would pass through each other"
                if depth.max() > 2.0 * DEEPEST and piece > 1:
                    length = (piece - 1) / min(pieces, 64)
                break
        conditions.force[:] = force
        return length, note

    # --- evaluation -----------------------------------------------------------------------------

    def _linearise(self, dt: float) -> None:
        """Stiffness at the trial state, and the contact stiffnesses that follow from it."""
        first = self.floor == 0.0
        self.stiffness = self.balance.stiffness(dt)
        diagonal = np.abs(self.stiffness.diagonal()).reshape(self.u.shape)
        self.floor = FLOOR * float(diagonal.max()) * self.size * 1e-2
        self.flexibility = np.divide(self.free, diagonal, out=np.zeros_like(diagonal), where=diagonal > 0.0)
        if not self.balance.dynamic:
            # also of bodies that are carried far before anything loads them; what flies away is not in balance
            moved = min(float(np.abs(self.u).max()), AWAY * self.size)
            np.multiply(ROUND_OFF * (self.farthest + moved), diagonal, out=self.round_off)
        if self.contact is not None:
            self.contact.scale(self.flexibility)
        if first:
            self._balance()

    def _evaluate(self, dt: float) -> None:
        """Forces, gaps and the enforcement's answer at the trial state."""
        self.equations.internal_force(dt)
        self._balance()

    def _balance(self) -> None:
        if self.contact is not None:
            self.contact.evaluate(self.equations.position)
            self.contact.enforcement.respond(self.contact.conditions, self.response)
        self.parts = self.balance.unbalanced(self.force)

    def _residual(self) -> Residual:
        # against forces so small that round-off is all there is, it is what they are measured by
        scale = np.maximum(force_scale(list(self.parts), self.floor), self.round_off / self.tolerance)
        unbalanced = float((np.abs(self.force) * self.free / scale).max())
        contact = contact_residual(self.contact.conditions, self.response) if self.contact is not None else 0.0
        return Residual(unbalanced, contact)

    def _record(self, residual: Residual, changed: int, length: float, note: str) -> Iteration:
        status = self.response.status
        return Iteration(
            residual.force, residual.contact, int(np.count_nonzero(status)), int(np.count_nonzero(status == 1)),
            changed, length, note,
        )  # fmt: skip


def take_back(equations: ImplicitEquations, state: State, start: Floats) -> None:
    """The state as it was at the `start` of a step, and the equations with it, bit for bit."""
    state.restore(start)
    equations.begin(0.0)
    equations.internal_force(0.0)
    # forces of that evaluation may differ from those that were reached by a step, in their last digits
    state.restore(start)
