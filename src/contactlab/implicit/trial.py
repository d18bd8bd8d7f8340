"""The state while a step is iterated: displacements, multipliers, and the forces and conditions that belong to them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from contactlab.api import Floats, ImplicitContact, ImplicitEquations, Response, State


class Balance(Protocol):
    """The forces of a step, their derivative and the stresses behind them."""

    def update_stresses(self, dt: float) -> None:
        """Stresses that belong to the trial displacements of a step of length dt [s]."""

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill `out` (N, 2) with external and contact forces minus all others; returns the forces by kind."""

    def stiffness(self, dt: float) -> Any:
        """Derivative of minus the unbalanced forces without contact, (2N, 2N) CSC."""

    def of_stresses(self, diagonal: Floats) -> Floats:
        """The part of the `diagonal` (N, 2) [N/mm] of `stiffness` that stresses give."""


STUCK = 1e6  # coefficient of friction of surfaces that are to stick


class Trial:
    """Displacements `u` and multipliers of the state, changed in place, and what follows from them.

    force     (N, 2) [N] unbalanced forces
    parts     the forces that they are made of, by kind
    response  what the enforcement answers to the contact conditions
    held      (p,) degrees of freedom whose displacement is given
    sticks    whether all surfaces with friction that press stick for now, whatever their bounds are
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
        """What prescribed degrees of freedom are short of their displacements `target` (p,) [mm]."""
        return target - self.u.reshape(-1)[self.held]

    def evaluate(self, dt: float) -> None:
        """Stresses, gaps, the enforcement's answer and unbalanced forces at the trial displacements and multipliers."""
        self.balance.update_stresses(dt)
        self.update_forces()

    def update_forces(self) -> None:
        """As `evaluate`, where the displacements are those of the last one."""
        if self.contact is not None:
            self.contact.evaluate(self.equations.position)
            self._respond(self.contact)
        self.parts = self.balance.unbalanced(self.force)

    def _respond(self, contact: ImplicitContact) -> None:
        """Ask the enforcement, with bounds that friction does not reach if surfaces are to stick."""
        conditions = contact.conditions
        if self.sticks:
            kept = conditions.bound
            rubs = (kept > 0.0).any(axis=0)
            conditions = replace(conditions, bound=np.where(rubs, [[STUCK], [0.0], [np.inf]], kept))
        contact.enforcement.respond(conditions, self.response)


class ContactForces:
    """Forces [N] that the trial's multipliers put on the nodes.

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
        """Both together (N, 2), as they were computed last."""
        return self.normal + self.tangential if len(self.tangential) else self.normal
