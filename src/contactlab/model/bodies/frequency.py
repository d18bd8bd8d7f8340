"""Lowest natural frequency excited by the loading; sets the duration of quasi-static runs."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from contactlab.api import Floats, Ints
from contactlab.model.bodies.body import Body
from contactlab.model.bodies.stiffness import cell_stiffness

ROUND = 1e-12  # of the mean stiffness over mass: rigid motions keep round-off of the moduli


def loaded_frequency(body: Body, positions: Floats, mass: Floats, fixed: Ints, directions: Floats) -> float:
    """Circular frequency [1/s] of the lowest mode that pushing along `directions` (d, 2) excites.

    Rayleigh's method: the deflection u under its own inertia forces in a direction gives
    w^2 = u K u / u M u, a few per cent above the mode's own. `fixed` dofs (2 * node + component) are
    held. A body that they leave adrift is stretched evenly instead.
    inf where every degree of freedom is held.
    """
    n, a = body.cells.shape
    dof = (2 * body.cells[:, :, None] + np.arange(2)).reshape(n, 2 * a)
    rows, columns = np.repeat(dof, 2 * a, axis=1).ravel(), np.tile(dof, (1, 2 * a)).ravel()
    size = 2 * len(positions)
    stiffness = coo_matrix((cell_stiffness(body, positions).ravel(), (rows, columns)), shape=(size, size)).tocsc()
    everything = np.unique(dof)
    own = np.setdiff1d(everything, fixed)
    if not len(own):
        return float("inf")
    nodal = np.repeat(mass, 2)[own]
    reduced = stiffness[own][:, own]
    if _adrift(reduced, positions, nodal, own):
        shapes = [_stretch(positions, nodal, own)]
    else:
        solve = splu(reduced).solve
        shapes = [solve(nodal * direction[own % 2]) for direction in directions]
    squares = [(u @ (reduced @ u)) / (u @ (nodal * u)) for u in shapes if np.any(u)]
    return float(np.sqrt(min(squares))) if squares else float("inf")


def _adrift(stiffness: Any, positions: Floats, nodal: Floats, own: Ints) -> bool:
    """Whether the supports leave the body some rigid motion, which costs no energy."""
    x = positions - positions[own // 2].mean(axis=0)
    turn = np.stack([-x[:, 1], x[:, 0]], axis=1).reshape(-1)[own]
    modes = np.stack([own % 2 == 0, own % 2 == 1, turn / np.abs(x).max()], axis=1).astype(np.float64)
    energy, inertia = modes.T @ (stiffness @ modes), modes.T @ (nodal[:, None] * modes)
    # a support that holds any of them strains its cells: far above round-off of the stiffest ones
    rigid = ROUND * stiffness.diagonal().sum() / nodal.sum()
    return bool(eigh(energy, inertia, eigvals_only=True)[0] < rigid)


def _stretch(positions: Floats, nodal: Floats, own: Ints) -> Floats:
    """An even stretch about the centre of mass: how neighbours squeeze a body that nothing else holds."""
    x = positions.reshape(-1)[own]
    centre = [(x * nodal)[own % 2 == c].sum() / nodal[own % 2 == c].sum() for c in range(2)]
    return np.asarray(x - np.asarray(centre)[own % 2])
