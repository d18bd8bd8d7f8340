"""The state during the iteration of a step: displacements, multipliers, and their forces and constraints."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from contactlab.api import Floats, ImplicitContact, ImplicitEquations, Response, State


class Balance(Protocol):
    """The forces of a step, their derivative and the stresses behind them."""

    def update_stresses(self, dt: float) -> None:
        """Compute stresses at the trial displacements of a step of length dt [s]."""

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill `out` (N, 2) with external and contact forces minus all others. Return the forces by kind."""

    def stiffness(self, dt: float) -> Any:
        """Return the derivative of minus the unbalanced forces without contact, (2N, 2N) CSC."""

    def of_stresses(self, diagonal: Floats) -> Floats:
        """Return the part of the `diagonal` (N, 2) [N/mm] of `stiffness` by stresses."""


STUCK = 1e6  # coefficient of friction of surfaces that are to stick


class Trial:
    """Displacements `u` and multipliers of the state, changed in place, and derived quantities.

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
        """Nodal contact forces (r, k) [N] of the trial; (1, 0) without contact."""
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
