"""Convergence criteria of an iteration: residuals over scales that follow from the model itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Conditions, Floats, Ints, Response

AWAY = 100.0  # times the size of the model: a larger correction means that nothing holds a body
FLOOR = 1e-10  # of the stiffest node's force at one unit of displacement per cell: nothing is loaded yet
ROUND_OFF = 8.0 * float(np.finfo(float).eps)  # of the force of the largest displacement or position: limit of accuracy
LOOSER = 1e-3  # weight of a constraint residual against an unbalanced force, whose error affects all nodes


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
