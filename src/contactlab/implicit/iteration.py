"""Newton's iteration for one step: the same for load steps and steps in time."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from contactlab.api import Floats, ImplicitEquations, Iteration, State
from contactlab.api.frame import SLIP
from contactlab.implicit.factor import SingularSystem, with_diagonal
from contactlab.implicit.saddle import SaddleSystem
from contactlab.implicit.trial import AWAY, SHORTEST, Balance, LineSearch, Residual, Scales, Trial, force_scale

AUGMENTATIONS = 40  # times the iterations of a step, for augmentations
TAKEOVERS = 40  # times that friction may take newer normal forces or slips in a step
FALLING, FALL = 6, 0.9  # residuals in a row, each below the last: then more iterations are made
MORE = 4  # times the wished iterations, at most
TOUCHING = 1e-9  # segment lengths
SOFT = 1e-10  # of the stiffest node: springs for a body that nothing holds yet
NEAR, FARTHEST = 0.01, 2.0  # depth in segments at which a body meets its contact; search distance in model sizes
LEAP, SMALL = 30.0, 0.01  # limits of sliding per correction: times the step's motion so far, sizes of the model
STICKS, RELEASED = 3, 1e-3  # times in a step that all surfaces stick temporarily; residual that ends it


@dataclass
class Outcome:
    """End of the iteration of a step; `reason` is empty if it converged.

    longest  see `contactlab.api.Step`
    motion   (N, 2) [mm] result of `contactlab.api.ImplicitMotion.solve`
    """

    reason: str = ""
    residual: Residual = field(default_factory=lambda: Residual(0.0, 0.0))
    trace: list[Iteration] = field(default_factory=list)
    longest: float | None = None
    motion: Floats = field(default_factory=lambda: np.zeros((0, 2)))


class NewtonIteration:
    """Iterates one run's steps; works on the state's displacement and multipliers in place.

    trial   the state that is iterated, and the forces that belong to it
    scales  scales of forces and lengths
    search  line search for each correction
    system  the linear system of displacements and multipliers
    """

    def __init__(
        self, equations: ImplicitEquations, state: State, balance: Balance, tolerance: float, most: int
    ) -> None:
        self.tolerance, self.most = tolerance, most
        self.trial = Trial(equations, state, balance)
        self.scales = Scales(equations.reference, self.trial.held)
        self.search = LineSearch(self.trial, self.scales)
        self.system = SaddleSystem(equations.reference, self.trial.held)
        self.stuck = 0  # times that all surfaces were made to stick in this step
        self.takeovers = 0  # times that friction took newer normal forces or slips in this step
        self.start: Floats = self.trial.u.copy()  # displacements at the start of the step
        self.soft = False  # True if the last correction needed soft springs

    def run(self, dt: float, target: Floats, limited: int | None = None) -> Outcome:
        """Iterate until the state is in balance with prescribed displacements `target` (p,) [mm].

        limited  number of shortened corrections before the step is given up; None: any number
        """
        outcome, trial = Outcome(), self.trial
        self.system.solver.forget()
        self.takeovers = self.stuck = 0
        trial.sticks = False
        self.search.forget()
        self.scales.floor, self.start = 0.0, trial.u.copy()
        trial.balance.update_stresses(dt)
        given = np.zeros(trial.u.size)
        began, softly = 0, 0  # iterations at the last augmentation; times that only soft springs kept balance
        while self._goes_on(outcome.trace[began:]):
            self._update_stiffness(dt)
            if not outcome.trace and self._at_rest(target, outcome):
                return outcome
            given[trial.held] = trial.still_to_move(target)
            try:
                left = outcome.residual.largest if outcome.trace else np.inf
                du, dy = self._correction(given, left)
                note, length, changed = self.search.take(dt, du.reshape(trial.u.shape), dy, given)
            except SingularSystem as problem:
                outcome.reason = f"the linear system has no solution ({problem}): a body may be held by nothing"
                return outcome
            if length == 0.0:
                outcome.reason = f"no fraction of the correction above {SHORTEST:.3f} can be taken: {note}"
                return outcome
            residual = self._residual()
            if trial.sticks and residual.largest <= RELEASED:
                trial.sticks = False
                trial.update_forces()
                self.search.forget()
                residual = self._residual()
            outcome.residual = residual
            rest = float(np.abs(trial.still_to_move(target)).max(initial=0.0))
            outcome.trace.append(self._record(residual, changed, length, note))
            trial.equations.iterated()
            if residual.largest <= self.tolerance and rest == 0.0:
                if softly := softly + 1 if self.soft else 0:
                    if softly > 1:
                        outcome.reason = "in balance, and nothing would resist if a body were pushed"
                        return outcome
                elif not (self._unsettled(outcome) or self._augment(outcome)):
                    return outcome
                if outcome.reason:
                    return outcome
                began = len(outcome.trace)
            if not np.isfinite(residual.largest):
                outcome.reason = "forces are no longer finite"
                return outcome
            if limited is not None and sum(one.length < 1.0 for one in outcome.trace) >= limited:
                outcome.reason = f"{limited} corrections had to be shortened: {note}"
                return outcome
        ones = "1 iteration" if len(outcome.trace) == 1 else f"{len(outcome.trace)} iterations"
        outcome.reason = f"{ones} left residuals of {residual.force:.1e} (forces) and {residual.contact:.1e} (contact)"
        return outcome

    def _at_rest(self, target: Floats, outcome: Outcome) -> bool:
        """Return whether the state is in balance unchanged: nothing was moved or loaded, nothing is left to solve."""
        if np.any(self.trial.still_to_move(target)):
            return False
        outcome.residual = self._residual()
        return outcome.residual.largest <= self.tolerance and not (self._unsettled(outcome) or self._augment(outcome))

    def _goes_on(self, trace: list[Iteration]) -> bool:
        """Return whether to iterate again: up to the wished number, and further while residuals fall steadily."""
        if len(trace) < self.most:
            return True
        left = [max(one.force, one.contact) for one in trace[-FALLING:]]
        fell = len(left) == FALLING and all(new < FALL * old for old, new in pairwise(left))
        return fell and len(trace) < MORE * self.most

    def _unsettled(self, outcome: Outcome) -> bool:
        """Return whether friction has taken newer normal forces or slips; sets the reason after too many times."""
        contact = self.trial.contact
        if contact is None or contact.settled():
            return False
        self.takeovers += 1
        if self.takeovers > TAKEOVERS:
            outcome.reason = (
                f"friction did not settle after {TAKEOVERS} times that it took newer normal forces or rates of slip"
            )
        self.trial.update_forces()
        if outcome.trace:
            outcome.trace[-1] = outcome.trace[-1]._replace(note="friction takes the new forces and slips")
        return True

    def _augment(self, outcome: Outcome) -> bool:
        """Return whether the enforcement continues from its forces, which then become its anchor."""
        contact = self.trial.contact
        if contact is None or not contact.enforcement.augments:
            return False
        y, anchor = self.trial.multipliers, contact.conditions.anchor
        left = float(np.abs(y - anchor).max(initial=0.0))
        if left <= self.tolerance * max(float(np.abs(y).max(initial=0.0)), self.scales.floor):
            return False
        anchor[:] = y
        self.trial.update_forces()
        if outcome.trace:
            note = f"forces taken over, which had changed by {left:.1e} N"
            outcome.trace[-1] = outcome.trace[-1]._replace(note=note)
        return len(outcome.trace) < AUGMENTATIONS * self.most

    # --- one iteration --------------------------------------------------------------------------

    def _correction(self, given: Floats, left: float) -> tuple[Floats, Floats]:
        """Return corrections of displacements and multipliers; friction alone holds parts from first contact on."""
        contact, self.soft, away = self.trial.contact, False, self._away(given)
        try:
            du, dy = self._solved(given, left)
        except SingularSystem as singular:
            problem = str(singular)
        else:
            farthest = float(np.abs(du).max())
            if farthest <= away or self.scales.size == 0.0:
                return du, dy
            problem = f"it moves nodes by {farthest / self.scales.size:.0e} times the size of the model"
        if self._stick():
            return self._correction(given, left)
        if self._hold():
            return self._solved(given, left)
        if contact is None:
            raise SingularSystem(problem)
        return self._softly(given, problem)

    def _stick(self) -> bool:
        """Let all surfaces with friction stick until the iteration is near balance. Return whether any slid before.

        While all of a body's surfaces slide, almost nothing resists its rolling.
        """
        if self.trial.sticks or self.stuck == STICKS or not self._slides():
            return False
        self.trial.sticks, self.stuck = True, self.stuck + 1
        self.trial.update_forces()
        return True

    def _slides(self) -> bool:
        contact = self.trial.contact
        return contact is not None and bool(len(contact.conditions.slip) and np.any(self.trial.response.status == SLIP))

    def _away(self, given: Floats) -> float:
        """Return the largest motion [mm] of a correction up to which bodies count as held."""
        moved = max(float(np.abs(self.trial.u - self.start).max()), float(np.abs(given).max()))
        if not self.trial.sticks and self.stuck < STICKS and self._slides():
            return max(LEAP * moved, SMALL * self.scales.size)
        return AWAY * self.scales.size

    def _softly(self, given: Floats, problem: str) -> tuple[Floats, Floats]:
        """Correct with soft springs for a body without contact yet; raise SingularSystem if nothing will hold it.

        A body driven by its load moves until surfaces meet, and nothing else does in this iteration; motions
        without load need only the springs until others hold them.
        """
        trial, self.soft = self.trial, True
        force, spring = trial.force.reshape(-1), SOFT * float(self.stiffness.diagonal().max())
        shifted = with_diagonal(self.stiffness, 1.0, np.full(force.size, spring))
        du, dy = self.system.step(shifted, force, np.zeros_like(given), trial.contact, trial.response, np.inf)
        drives = spring * float(du @ du) > 0.5 * float(force @ du) > 0.0
        if drives or np.abs(du).max() > AWAY * self.scales.size:
            du *= FARTHEST * self.scales.size / np.abs(du).max()
            assert trial.contact is not None
            place = trial.equations.reference + trial.u
            share = trial.contact.free_share(place, du.reshape(place.shape), NEAR)
            if share == 1.0:
                raise SingularSystem(problem)
            given[:] = 0.0
            return share * du, np.zeros_like(dy)
        if np.any(given):
            du, dy = self.system.step(shifted, force, given, trial.contact, trial.response, np.inf)
        if not np.abs(du).max() <= AWAY * self.scales.size:
            raise SingularSystem(problem)
        return du, dy

    def _solved(self, given: Floats, left: float) -> tuple[Floats, Floats]:
        t = self.trial
        largest = force_scale(list(t.parts), self.scales.floor)
        found = self.system.step(self.stiffness, t.force.reshape(-1), given, t.contact, t.response, left, largest)
        if t.contact is not None and t.contact.by_energy:
            self.scales.add(self.system.potentials.reshape(t.u.shape))
        return found

    def _hold(self) -> bool:
        """Let surfaces stick that touch without a force yet, as friction has no bound then. Return whether any do."""
        contact = self.trial.contact
        if contact is None or not len(contact.conditions.slip):
            return False
        c, y = contact.conditions, self.trial.multipliers[0]
        touch = c.present & (y == 0.0) & (np.abs(c.gap) <= TOUCHING * c.size)
        y[touch] = 2.0 * TOUCHING * c.stiffness[touch] * c.size[touch]
        self.trial.update_forces()
        return bool(touch.any())

    def _update_stiffness(self, dt: float) -> None:
        """Compute the stiffness of the bodies at the trial state, and the scales that follow from it.

        The first time it also computes the first forces. Contact is linearised in `SaddleSystem.step`.
        """
        trial, first = self.trial, self.scales.floor == 0.0
        self.stiffness = trial.balance.stiffness(dt)
        diagonal = np.abs(self.stiffness.diagonal()).reshape(trial.u.shape)
        self.scales.update(diagonal, trial.u, trial.balance.of_stresses(diagonal))
        if trial.contact is not None:
            trial.contact.scale(self.scales.flexibility)
        if first:
            trial.update_forces()

    def _residual(self) -> Residual:
        trial = self.trial
        unbalanced = self.scales.residual(trial.force, trial.parts, self.tolerance)
        if trial.contact is None:
            return Residual(unbalanced, 0.0)
        return Residual(unbalanced, self.scales.violation(trial.contact.conditions, trial.response, trial.parts))

    def _record(self, residual: Residual, changed: int, length: float, note: str) -> Iteration:
        status = self.trial.response.status
        return Iteration(
            residual.force, residual.contact, int(np.count_nonzero(status)), int(np.count_nonzero(status == 1)),
            changed, length, note, np.asarray(status + ord("0"), np.uint8).tobytes().decode(),
        )  # fmt: skip


def take_back(equations: ImplicitEquations, state: State, start: Floats) -> None:
    """Restore the state and the equations to the `start` of a step, bit for bit."""
    state.restore(start)
    equations.begin_step(0.0)
    equations.internal_force(0.0)
    # forces of this evaluation may differ from the forces reached by a step, in their last digits
    state.restore(start)
