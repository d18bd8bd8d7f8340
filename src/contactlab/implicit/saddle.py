"""A Newton step: linearised balance of forces and contact constraints in one saddle point system.

    [A - dF/du   -C^T] [du]   [unbalanced]
    [   -H        -B ] [dy] = [ residual ]

Rows and columns of the second kind exist only if an enforcement's constraint depends on a gap; forces
that it gives explicitly (open: none; slip: the bound) are eliminated before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from contactlab.api import ContactDerivatives, Floats, ImplicitContact, Ints, Response
from contactlab.implicit.factor import ReusedFactor
from contactlab.implicit.free_motions import FreeMotions
from contactlab.implicit.sparse import Indices, combined, picked, rows_of, scaled, summed_columns, total

Entries = tuple[Indices, Indices, Floats]
"""Rows, columns and values (e,) of a matrix."""

REDUNDANT = 3e-12  # softness of a constraint over nodal softness: redundant constraints share their force
RIGID = 1e-12  # share of a constraint's weights: below it no free degree of freedom takes part


@dataclass
class Elimination:
    """The unknown forces of a Newton step, and the values of the others.

    normal, tangential  slots (int) whose forces are unknowns
    change              (r, k) corrections of the explicit forces, in slip without the share of
                        their unknown normal force
    sliding_shear       (k,) d(y_t)/d(y_n) of constraints in slip
    residual, by_force  (r, k) divided by by_gap; cross (k,) likewise, of unknown tangential forces
    """

    normal: Indices
    tangential: Indices
    change: Floats
    sliding_shear: Floats
    residual: Floats
    by_force: Floats
    cross: Floats

    @cached_property
    def chosen(self) -> Indices:
        """Slots whose derivatives are needed."""
        moved = np.flatnonzero((self.change != 0.0).any(axis=0))
        return np.unique(np.concatenate([self.normal, self.tangential, moved]))


def eliminate(response: Response) -> Elimination:
    """Sort constraints into unknown and explicit forces."""
    r = response
    rows, slots = r.residual.shape
    unknown = r.by_gap != 0.0
    change, residual, by_force = (np.zeros((rows, slots)) for _ in range(3))
    np.divide(-r.residual, r.by_force, out=change, where=~unknown)
    np.divide(r.residual, r.by_gap, out=residual, where=unknown)
    # residuals are unchanged: softness costs a digit in eleven of an iteration, not of the solution
    np.divide(r.by_force + REDUNDANT, r.by_gap, out=by_force, where=unknown)
    sliding_shear, cross = np.zeros(slots), np.zeros(slots)
    if rows > 1:
        # a multiple of the normal row removes the gap from the tangential row
        share = r.cross_force - r.cross_gap * by_force[0]
        rest = r.residual[1] - r.cross_gap * residual[0] + np.where(unknown[0], 0.0, r.cross_force * change[0])
        share = np.where(unknown[0], share, 0.0)
        np.divide(-rest, r.by_force[1], out=change[1], where=~unknown[1])
        np.divide(-share, r.by_force[1], out=sliding_shear, where=~unknown[1])
        np.divide(rest, r.by_gap[1], out=residual[1], where=unknown[1])
        np.divide(share, r.by_gap[1], out=cross, where=unknown[1])
    tangential = np.flatnonzero(unknown[1]) if rows > 1 else np.zeros(0, np.int64)
    return Elimination(np.flatnonzero(unknown[0]), tangential, change, sliding_shear, residual, by_force, cross)


class SaddleSystem:
    """Assembles and solves Newton steps for one model.

    potentials  (2N,) [N/mm] diagonal of their stiffness in the last step that had any
    loose       motions that are left out, as in statics; None: inertia resists them
    """

    def __init__(self, reference: Floats, held: Ints) -> None:
        self.size = reference.size
        self.held = np.asarray(held)
        moving = np.ones(self.size, bool)
        moving[self.held] = False
        self.free = np.flatnonzero(moving)
        self.number = np.full(self.size, -1, np.int32)
        self.number[self.free] = np.arange(len(self.free))
        # entries of the stiffness between free degrees of freedom, and their number in each such column
        self._inner: tuple[Indices, Indices] | None = None
        self.solver = ReusedFactor(reference[self.free // 2])
        self.potentials = np.zeros(self.size)
        self.loose: FreeMotions | None = None

    def step(
        self,
        stiffness: Any,
        unbalanced: Floats,
        given: Floats,
        contact: ImplicitContact | None,
        response: Response,
        residual: float,
        largest: float = 0.0,
    ) -> tuple[Floats, Floats]:
        """Return corrections of displacements (2N,) and multipliers (r, k).

        stiffness   (2N, 2N) CSC, always of the same pattern
        unbalanced  (2N,) [N] external and contact forces minus internal forces
        given       (2N,) [mm] corrections of prescribed displacements
        residual    relative residual of the equilibrium, which sets the accuracy
        largest     [N] nodal force: motions that less than its round-off drives are left out
        """
        moving = bool(np.any(given))
        right = unbalanced - stiffness @ given if moving else unbalanced
        border: list[Entries] = []
        lower: list[Floats] = []
        forces, conditions = None, []
        plan = eliminate(response)
        if contact is not None and (len(plan.chosen) or contact.acts):
            derivatives = contact.linearise(plan.chosen.astype(np.int32))
            if contact.by_energy:
                self.potentials = np.abs(derivatives.force.diagonal())
            self._fill_rigid_rows(plan, derivatives, response)
            conditions = _conditions(plan, derivatives)
            border = self._border(plan, derivatives, conditions)
            right = right + _explicit_forces(plan, derivatives)
            if moving:
                right = right + derivatives.force @ given
            lower = _conditions_right(plan, conditions, given if moving else None)
            forces = derivatives.force
        kind = [plan.normal.tobytes(), plan.tangential.tobytes()]
        if self.loose is not None:  # finds nothing if supports hold every body
            self.loose.find(stiffness, right, forces, conditions, largest)
            pins = self.number[self.loose.pins]
            kind.append(pins.tobytes())
            if len(pins):
                border.append((pins, pins, np.abs(stiffness.diagonal()[self.loose.pins])))
        full = np.concatenate([right[self.free], *lower])
        solution = self.solver.solve(self._assembled(stiffness, border, len(full)), full, tuple(kind), residual)
        du = np.zeros(self.size)
        du[self.free] = solution[: len(self.free)]
        du[self.held] = given[self.held]
        if self.loose is not None:
            du = self.loose.without(du)
        return du, _forces(plan, solution[len(self.free) :])

    def _assembled(self, stiffness: Any, border: list[Entries], size: int) -> Any:
        """Assemble the matrix (CSC). Its parts are freed before the factorisation, which takes most of the memory."""
        parts = zip(self._own(stiffness), *border, strict=True)
        row, column, value = (np.concatenate(part) for part in parts)
        return summed_columns(row, column, value, (size, size))

    def _own(self, stiffness: Any) -> Entries:
        """Return entries of the stiffness between free degrees of freedom."""
        if self._inner is None:
            every = np.repeat(self.number, np.diff(stiffness.indptr))
            both = np.flatnonzero((self.number[stiffness.indices] >= 0) & (every >= 0)).astype(np.int32)
            self._inner = both, np.bincount(every[both], minlength=len(self.free)).astype(np.int32)
        inside, count = self._inner
        # rows and columns are rebuilt: stored, they would add to the peak memory of large systems
        column = np.repeat(np.arange(len(self.free), dtype=np.int32), count)
        return self.number[stiffness.indices[inside]], column, stiffness.data[inside]

    def _inside(self, matrix: Any) -> Entries:
        """Return entries of a (., 2N) matrix in free columns, rows unchanged."""
        row, column, value = _entries(matrix)
        column = self.number[column]
        keep = column >= 0
        return row[keep], column[keep], value[keep]

    def _fill_rigid_rows(self, plan: Elimination, derivatives: ContactDerivatives, response: Response) -> None:
        """Fill rows of forces without effect, if supports alone decide a constraint, as slip of a held node.

        Such a force answers the residual of its own constraint, until a bound gives it: the system stays regular.
        """
        for kind, (slots, rows) in enumerate(((plan.normal, derivatives.gap), (plan.tangential, derivatives.slip))):
            if len(slots):
                row = rows_of(rows)
                weights = np.abs(rows.data)
                total = np.bincount(row, weights, rows.shape[0])
                moving = np.bincount(row, weights * (self.number[rows.indices] >= 0), rows.shape[0])
                held = moving < RIGID * np.maximum(total, 1.0)
                rigid = slots[held[np.searchsorted(plan.chosen, slots)]]
                plan.by_force[kind, rigid] = 1.0 / response.by_gap[kind, rigid]

    def _border(self, plan: Elimination, derivatives: ContactDerivatives, conditions: list[Any]) -> list[Entries]:
        """Return entries of contact: change of forces, columns and rows of the unknown multipliers."""
        first = len(self.free)
        second = first + len(plan.normal)
        row, column, value = _entries(derivatives.force)
        row, column = self.number[row], self.number[column]
        keep = (row >= 0) & (column >= 0)
        parts: list[Entries] = [(row[keep], column[keep], -value[keep])]
        at = np.searchsorted(plan.chosen, plan.normal)
        directions = picked(derivatives.normal, at)
        if derivatives.tangent is not None and plan.sliding_shear.any():
            directions = total(directions, scaled(picked(derivatives.tangent, at), plan.sliding_shear[plan.normal]))
        parts += self._both(directions, conditions[0], first, plan.by_force[0, plan.normal])
        if len(plan.tangential):
            at = np.searchsorted(plan.chosen, plan.tangential)
            tangent = picked(derivatives.tangent, at)
            parts += self._both(tangent, conditions[1], second, plan.by_force[1, plan.tangential])
            crossed = np.flatnonzero(plan.cross[plan.tangential])
            place = first + np.searchsorted(plan.normal, plan.tangential[crossed])
            parts.append((second + crossed, place, -plan.cross[plan.tangential[crossed]]))
        return parts

    def _both(self, directions: Any, derivatives: Any, first: int, diagonal: Floats) -> list[Entries]:
        """Return columns of one kind of multipliers, their rows, and their diagonal."""
        row, column, value = self._inside(directions)
        parts = [(column, first + row, -value)]
        row, column, value = self._inside(derivatives)
        parts.append((first + row, column, -value))
        place = first + np.arange(len(diagonal))
        parts.append((place, place, -diagonal))
        return parts


def _entries(matrix: Any) -> Entries:
    """Return rows, columns and values of a sparse matrix."""
    rows = matrix.tocsr()
    return rows_of(rows), rows.indices, rows.data


def _explicit_forces(plan: Elimination, derivatives: ContactDerivatives) -> Floats:
    """Return nodal forces (2N,) of the corrections that are known before the solution."""
    chosen = plan.chosen
    forces = combined(derivatives.normal, plan.change[0, chosen])
    if derivatives.tangent is not None:
        forces = forces + combined(derivatives.tangent, plan.change[1, chosen])
    return forces


def _conditions(plan: Elimination, derivatives: ContactDerivatives) -> list[Any]:
    """Return derivatives (., 2N) of gaps, and of slips if there are any, of the constraints with unknown forces."""
    found = [picked(derivatives.gap, np.searchsorted(plan.chosen, plan.normal))]
    if len(plan.tangential):
        found.append(picked(derivatives.slip, np.searchsorted(plan.chosen, plan.tangential)))
    return found


def _conditions_right(plan: Elimination, conditions: list[Any], given: Floats | None) -> list[Floats]:
    """Return right-hand sides of the constraints with unknown forces."""
    lower = [plan.residual[0, plan.normal]]
    if len(plan.tangential):
        lower.append(plan.residual[1, plan.tangential])
    if given is not None:
        return [right + rows @ given for right, rows in zip(lower, conditions, strict=True)]
    return lower


def _forces(plan: Elimination, unknown: Floats) -> Floats:
    """Return corrections of all multipliers (r, k), found and given."""
    change, normal = plan.change.copy(), np.zeros(plan.change.shape[1])
    normal[plan.normal] = unknown[: len(plan.normal)]
    change[0, plan.normal] = normal[plan.normal]
    if len(change) > 1:
        change[1] += plan.sliding_shear * normal
        change[1, plan.tangential] = unknown[len(plan.normal) :]
    return change
