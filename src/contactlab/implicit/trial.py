"""The state during the iteration of a step, with its forces and constraints, and how far a correction of it is taken.

Residuals are judged by scales that follow from the model itself. Corrections are shortened if cells fold, surfaces pass
through each other, or contact states cycle.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from contactlab.api import Conditions, Floats, ImplicitContact, ImplicitEquations, Ints, Response, State

STUCK = 1e6  # coefficient of friction of surfaces that are to stick
DEEPEST = 1.0  # segment lengths that a correction may push a surface into the other
CAREFUL = (1.0, 0.5, 0.25, 0.125)  # fractions tried once contact states cycle
SHORTEST = 1.0 / 64.0  # of a correction: below it the step is given up
FEW_CELLS = 50.0  # segments across the model, if no constraint gives their length
MOST_PIECES = 64  # of a correction, with constraints evaluated at their ends
AWAY = 100.0  # times the size of the model: a larger correction means that nothing holds a body
FLOOR = 1e-10  # of the stiffest node's force at one unit of displacement per cell: nothing is loaded yet
ROUND_OFF = 8.0 * float(np.finfo(float).eps)  # of the force of the largest displacement or position: limit of accuracy
LOOSER = 1e-3  # weight of a constraint residual against an unbalanced force, whose error affects all nodes


class Balance(ABC):
    """A step that is iterated: stresses, unbalanced forces, and their derivative without contact."""

    @abstractmethod
    def update_stresses(self, dt: float) -> None:
        """Compute stresses where the step needs them."""

    @abstractmethod
    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill unbalanced forces (N, 2) [N], and return their terms by kind."""

    @abstractmethod
    def stiffness(self, dt: float) -> Any:
        """Return the derivative (2N, 2N) [N/mm] of the unbalanced forces, with the opposite sign."""

    @abstractmethod
    def of_stresses(self, diagonal: Floats) -> Floats:
        """Return the part of the `diagonal` (N, 2) [N/mm] of `stiffness` by stresses."""


class Trial:
    """Displacements `u` and multipliers of the state, changed in place, and derived quantities.

    balance   the step that is iterated
    force     (N, 2) [N] unbalanced forces
    parts     the terms of these forces, by kind
    response  response of the enforcement to the contact constraints
    held      (p,) degrees of freedom whose displacement is given
    sticks    True while all surfaces with friction and pressure stick, whatever their bounds are
    """

    def __init__(self, equations: ImplicitEquations, state: State, balance: Balance) -> None:
        self.equations, self.balance, self.contact = equations, balance, equations.contact
        self.u, self.held = state["displacement"], equations.prescribed.dof
        self.sticks = False
        self.force: Floats = np.zeros((len(equations.reference), 2))
        self.parts: tuple[Floats, ...] = ()
        multipliers = state["multipliers"] if self.contact is not None else np.zeros((1, 0))
        self.response = Response.allocate(*multipliers.shape)
        self._none: Floats = np.zeros_like(multipliers)

    @property
    def multipliers(self) -> Floats:
        """Nodal contact forces (r, k) [N] of the trial, see `ImplicitContactSystem`; (1, 0) without contact."""
        return self.contact.conditions.force if self.contact is not None else self._none

    def still_to_move(self, target: Floats) -> Floats:
        """Return the remaining motion of prescribed degrees of freedom to their displacements `target` (p,) [mm]."""
        return target - self.u.reshape(-1)[self.held]

    def evaluate(self, dt: float) -> None:
        """Compute stresses, gaps, the enforcement's response and unbalanced forces at the trial state."""
        self.balance.update_stresses(dt)
        self.update_forces()

    def update_forces(self) -> None:
        """Evaluate at the displacements of the last `evaluate`."""
        if self.contact is not None:
            self.contact.evaluate(self.equations.position)
            self._respond(self.contact)
        self.parts = self.balance.unbalanced(self.force)

    def _respond(self, contact: ImplicitContact) -> None:
        """Call the enforcement, with bounds that friction does not reach if surfaces are to stick."""
        conditions = contact.conditions
        if self.sticks:
            kept = conditions.bound
            rubs = (kept > 0.0).any(axis=0)
            conditions = replace(conditions, bound=np.where(rubs, [[STUCK], [0.0], [np.inf]], kept))
        contact.enforcement.respond(conditions, self.response)


class ContactForces:
    """Nodal forces [N] of the trial's multipliers.

    normal      (N, 2)
    tangential  (N, 2), or (0, 2) without friction
    """

    def __init__(self, equations: ImplicitEquations) -> None:
        nodes, self.contact = len(equations.reference), equations.contact
        friction = self.contact is not None and len(self.contact.conditions.slip) > 0
        self.normal: Floats = np.zeros((nodes, 2))
        self.tangential: Floats = np.zeros((nodes if friction else 0, 2))

    def add_to(self, out: Floats, weight: float = 1.0) -> None:
        """Compute both at the present multipliers, and add them times a weight to `out` (N, 2)."""
        if self.contact is None:
            return
        self.contact.forces(self.normal, self.tangential)
        out += weight * self.normal
        if len(self.tangential):
            out += weight * self.tangential

    def total(self) -> Floats:
        """Sum of both (N, 2), as last computed."""
        return self.normal + self.tangential if len(self.tangential) else self.normal


class LineSearch:
    """Applies corrections of one trial; remembers the patterns of contact states within a step."""

    def __init__(self, trial: Trial, scales: Scales) -> None:
        self.trial, self.scales = trial, scales
        self.seen: set[bytes] = set()
        self.circling = False

    def forget(self) -> None:
        """Begin a step without seen patterns of contact states."""
        self.seen.clear()
        self.circling = False

    def take(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float, int]:
        """Correct the trial once. Return the reason of a limit, the fraction taken, and the number of state changes.

        du     (N, 2) [mm] correction of the displacements
        dy     (r, k) [N] correction of the multipliers
        given  (2N,) [mm] motion of prescribed degrees of freedom by a full correction
        """
        response = self.trial.response
        before = response.status.copy()
        note, length = self._careful(dt, du, dy, given) if self.circling else self._move(dt, du, dy, given)
        changed = int(np.count_nonzero(response.status != before))
        if changed:
            pattern = response.status.tobytes()
            self.circling = self.circling or pattern in self.seen
            self.seen.add(pattern)
        return note, length, changed

    def _careful(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float]:
        """Try several step lengths if contact states cycle, and keep the one with the smallest residual."""
        u, y = self.trial.u, self.trial.multipliers
        start, y_start, found = u.copy(), y.copy(), []
        for part in CAREFUL:
            u[:], y[:] = start, y_start
            note, length = self._move(dt, part * du, part * dy, given if part == 1.0 else part * given)
            found.append((self._left_to_do(), part * length, part, note))
            if found[-1][0] < found[0][0] and found[-1] > min(found):
                break
        _, length, part, note = min(found)
        if part != found[-1][2]:
            u[:], y[:] = start, y_start
            self._move(dt, part * du, part * dy, given if part == 1.0 else part * given)
        return note or ("" if part == 1.0 else "contact states cycle"), length

    def _left_to_do(self) -> float:
        """Return the sum of squares [mm^2] of unbalanced forces and constraint residuals, each over its stiffness."""
        trial = self.trial
        rest = float((trial.force**2 * self.scales.flexibility**2).sum())
        if trial.contact is not None:
            c = trial.contact.conditions
            rest += float((trial.response.residual[:, c.present] ** 2 / c.stiffness[c.present] ** 2).sum())
        return rest if np.isfinite(rest) else np.inf

    def _move(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float]:
        """Apply as much of a correction as keeps cells unfolded and surfaces from passing through each other."""
        trial, u, y = self.trial, self.trial.u, self.trial.multipliers
        start, y_start = u.copy(), y.copy()
        length, note = self._reach(start, du)
        shortest, work = SHORTEST * length, self._work(du, given)
        while length >= shortest > 0.0:
            u[:] = start + length * du
            if length == 1.0:
                u.reshape(-1)[trial.held] = (start.reshape(-1) + given)[trial.held]
            y[:] = y_start + length * dy
            trial.evaluate(dt)
            sense = not trial.equations.folded() and bool(np.isfinite(trial.force).all())
            if sense and (length <= 2.0 * shortest or abs(float(np.vdot(trial.force * self.scales.free, du))) <= work):
                return note, length
            length, note = 0.5 * length, "the energy of contact grows" if sense else "cells fold over"
        return note, 0.0

    def _work(self, du: Floats, given: Floats) -> float:
        """Return the largest work of unbalanced forces along a correction at its end; with potentials, at its start.

        A correction that ends at growing potential energy has gone too far. While supports move, or
        with constraints, there is no energy that would fall.
        """
        contact = self.trial.contact
        if contact is None or not contact.by_energy or np.any(given) or contact.conditions.present.any():
            return np.inf
        return abs(float(np.vdot(self.trial.force * self.scales.free, du)))

    def _reach(self, start: Floats, du: Floats) -> tuple[float, str]:
        """Return the fraction of a correction at which a surface penetrates too deep, or a node passes through."""
        contact = self.trial.contact
        if contact is None:
            return 1.0, ""
        conditions, place = contact.conditions, self.trial.equations.reference + start
        smallest = float(conditions.size[conditions.present].min(initial=np.inf))
        if not np.isfinite(smallest):
            smallest = self.scales.size / FEW_CELLS
        pieces = int(np.ceil(np.hypot(*du.T).max() / smallest))
        length = contact.free_share(place, du, DEEPEST)
        if 1 < pieces <= MOST_PIECES:  # a correction by less than a segment is taken whole
            length = min(length, self._watched(place, du, pieces))
        return length, "surfaces would pass through each other" if length < 1.0 else ""

    def _watched(self, place: Floats, du: Floats, pieces: int) -> float:
        """Return the fraction of a correction at which a constraint penetrates too deep; 1 if none does."""
        contact = self.trial.contact
        assert contact is not None
        conditions, length, y = contact.conditions, 1.0, self.trial.multipliers
        before = y.copy()
        for piece in range(1, pieces + 1):
            contact.evaluate(place + piece / pieces * du)
            depth = np.divide(
                -conditions.gap, conditions.size, out=np.zeros_like(conditions.gap), where=conditions.present
            )
            if depth.max() > DEEPEST:
                length = (piece - 1 if depth.max() > 2.0 * DEEPEST and piece > 1 else piece) / pieces
                break
        y[:] = before
        return length


# --- convergence criteria -------------------------------------------------------------------------------------------


class Residual(NamedTuple):
    """force: largest unbalanced nodal force over the largest nodal force; contact: largest residual of a
    constraint, see `contact_residual`."""

    force: float
    contact: float

    @property
    def largest(self) -> float:
        """The larger of the two residuals."""
        return max(self.force, self.contact)


def force_scale(parts: list[Floats], floor: float) -> float:
    """Return the largest component of any nodal force [N], not below `floor`."""
    return max(floor, *(float(np.abs(part).max(initial=0.0)) for part in parts))


def contact_residual(conditions: Conditions, response: Response, force: float, exact: float) -> float:
    """Return the largest residual of a constraint: overlaps, gaps under pressure, slips in stick and so on.

    It is the larger of |C|/(c h), in segment lengths, and of a thousandth of |C|/force: under a small load a residual
    that is small against segments may equal much of the contact force.

    force  [N] largest nodal force of the model, > 0
    exact  [mm] round-off of positions: gaps below it are ignored relative to forces
    """
    c = conditions
    if not c.present.any():
        return 0.0
    stiffness, left = c.stiffness[c.present], np.abs(response.residual[:, c.present])
    beyond = np.where(left > exact * stiffness, left, 0.0)
    return float(np.maximum(left / (stiffness * c.size[c.present]), LOOSER * beyond / force).max())


class Scales:
    """Reference lengths and forces of one model for an iteration.

    size         [mm] of the undeformed model
    exact        [mm] round-off of positions
    floor        [N] forces below it are ignored; 0 until the first `update` of a step
    round_off    (N, 2) [N] of the forces of stresses and potentials, by node and direction
    flexibility  (N, 2) [mm/N] of single nodes, 0 if they are held
    """

    def __init__(self, reference: Floats, held: Ints) -> None:
        self.size = float(np.ptp(reference, axis=0).max())
        self.farthest = float(np.abs(reference).max())
        self.free = np.ones_like(reference)
        self.free.reshape(-1)[held] = 0.0
        self.floor = self.exact = 0.0
        self.round_off: Floats = np.zeros_like(reference)
        self.flexibility: Floats = np.zeros_like(reference)

    def update(self, diagonal: Floats, u: Floats, stresses: Floats) -> None:
        """Take diagonals (N, 2) [N/mm] of the stiffness and of its part by `stresses`, at displacements `u` (N, 2)."""
        self.floor = FLOOR * float(diagonal.max()) * self.size * 1e-2
        self.flexibility = np.divide(self.free, diagonal, out=np.zeros_like(diagonal), where=diagonal > 0.0)
        # also for bodies carried far before anything loads them; a body that flies away is not in balance
        moved = min(float(np.abs(u).max()), AWAY * self.size)
        self.exact = ROUND_OFF * (self.farthest + moved)
        np.multiply(self.exact, stresses, out=self.round_off)

    def add(self, potentials: Floats) -> None:
        """Add the stiffness (N, 2) [N/mm] of potentials, which depend on gaps, differences of positions."""
        self.round_off += self.exact * potentials

    def residual(self, force: Floats, parts: tuple[Floats, ...], tolerance: float) -> float:
        """Return the largest unbalanced `force` (N, 2) of a free degree of freedom over the largest of `parts`."""
        # for forces as small as round-off, round-off is the scale
        scale = np.maximum(force_scale(list(parts), self.floor), self.round_off / tolerance)
        return float((np.abs(force) * self.free / scale).max())

    def violation(self, conditions: Conditions, response: Response, parts: tuple[Floats, ...]) -> float:
        """Return the largest constraint residual over the largest of the forces `parts` and segment lengths."""
        return contact_residual(conditions, response, force_scale(list(parts), self.floor), self.exact)
