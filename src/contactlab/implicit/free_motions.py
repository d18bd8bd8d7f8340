"""Rigid motions that nothing resists and no load drives: statics leave them out, so that bodies move least.

A block that stands without friction on a flat floor may stand anywhere. The system of a Newton step is singular then,
and round-off decides where the block ends. A spring at one degree of freedom for each such motion makes the system
regular. Without a load along the motion the spring carries no force, and the motion is then taken out of the
correction. Loads along a motion keep the system singular: they have no equilibrium.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import null_space, orth, qr
from scipy.sparse import csc_array, hstack
from scipy.sparse.csgraph import connected_components

from contactlab.api import Floats, Ints
from contactlab.implicit.factor import magnitudes

HELD = 1e-9  # of a unit motion: supports that hold less of it do not hold it
RESISTED = 1e-9  # of the largest resistance of a condition: round-off of normals far from the origin leaves 1e-11
STIFF = 1e-12  # the same of stiffnesses, whose round-off is 1e-15: soft springs under a stiff body resist with 1e-10
DRIVEN = 1e-9  # of the largest nodal force: a tenth of the usual tolerance of a node in balance


class FreeMotions:
    """Finds such motions of the parts of a model that its stiffness connects.

    reference  (2N,) [mm] undeformed positions
    held       (p,) degrees of freedom whose displacement is given
    modes      (2N, m) sparse, rigid motions that supports leave to the parts, of size one; None before the first system
    pins       (k,) degrees of freedom that hold the k motions of the last system
    motions    (2N, k) these motions, orthonormal
    """

    def __init__(self, reference: Floats, held: Ints) -> None:
        self.reference = reference.reshape(-1)
        self.free = np.ones(self.reference.size, bool)
        self.free[held] = False
        self.modes: Any = None
        self.pins = np.zeros(0, np.int64)
        self.motions: Floats = np.zeros((self.reference.size, 0))

    def find(self, stiffness: Any, right: Floats, forces: Any, conditions: list[Any], largest: float) -> None:
        """Find the motions of a system.

        stiffness   (2N, 2N) CSC; forces: derivative of contact forces likewise, or None
        right       (2N,) [N] right-hand side
        conditions  matrices (., 2N) of conditions with unknown forces
        largest     [N] nodal force
        """
        self.pins = self.pins[:0]
        if self.modes is None:
            self.modes = self._left_by_supports(stiffness)
        if not self.modes.shape[1]:
            return
        matrix = stiffness if forces is None else csc_array(stiffness - forces)
        resisted = [_resistance(one, self.modes, RESISTED) for one in conditions]
        rows = np.concatenate([_resistance(matrix, self.modes, STIFF, self.free), *resisted])
        _, sizes, directions = np.linalg.svd(np.linalg.qr(rows, mode="r") if len(rows) > rows.shape[1] else rows)
        unresisted = directions[int((sizes > 1.0).sum()) :].T
        driven = self.modes.T @ right @ unresisted
        # motions of supports are loads on the right
        if len(driven) and np.abs(driven).max() > DRIVEN * max(largest, float(np.abs(right).max())):
            unresisted = unresisted @ null_space(driven[None])
        if not unresisted.shape[1]:
            return
        moved = np.where(self.free[:, None], self.modes @ unresisted, 0.0)
        self.motions = np.linalg.qr(moved)[0]
        self.pins = np.sort(qr(self.motions.T, mode="r", pivoting=True)[1][: self.motions.shape[1]])

    def without(self, correction: Floats) -> Floats:
        """Return a correction (2N,) without the motions of the last system."""
        if not len(self.pins):
            return correction
        return np.asarray(correction - self.motions @ (self.motions.T @ np.where(self.free, correction, 0.0)))

    def _left_by_supports(self, stiffness: Any) -> Any:
        """Return `modes`."""
        count, part = connected_components(stiffness, directed=False)
        columns = []
        for number in range(count):
            own = part == number
            if not self.free[own].any():
                continue
            rigid = _rigid(self.reference, own)
            left = null_space(rigid[own & ~self.free], rcond=HELD) if (own & ~self.free).any() else np.eye(3)
            columns.append(csc_array(orth(rigid @ left, rcond=HELD)))  # a part may be a single degree of freedom
        return hstack(columns, format="csc") if columns else csc_array((self.reference.size, 0))


def _rigid(reference: Floats, own: Any) -> Floats:
    """Return displacements (2N, 3) of the degrees of freedom `own` in two shifts and a turn, of size one."""
    place, inside = reference.reshape(-1, 2), own.reshape(-1, 2)
    arm = np.where(inside, place - place[inside.any(axis=1)].mean(axis=0), 0.0)
    arm /= max(float(np.abs(arm).max()), 1e-300)
    modes = np.zeros((len(place), 2, 3))
    modes[:, 0, 0], modes[:, 1, 1] = inside.T
    modes[:, 0, 2], modes[:, 1, 2] = -arm[:, 1], arm[:, 0]
    return np.where(own[:, None], modes.reshape(-1, 3), 0.0)


def _resistance(matrix: Any, modes: Any, least: float, rows: Any = None) -> Floats:
    """Return the answers of the equations to each motion, over `least` times their largest; round-off is left out."""
    answer = (matrix @ modes).toarray()
    most = np.asarray(magnitudes(csc_array(matrix)).sum(axis=1)).ravel()
    answer /= least * np.where(most > 0.0, most, 1.0)[:, None]
    kept = np.abs(answer).max(axis=1) > 1e-3
    return np.asarray(answer[kept if rows is None else kept & rows])
