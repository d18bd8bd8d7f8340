"""Lowest elastic frequency of a model's bodies, by which quasi-static runs are paced."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import eigsh

from contactlab.api import Floats, Ints
from contactlab.model.body import Body
from contactlab.model.stiffness import cell_masses, cell_stiffness


def lowest_frequency(body: Body, positions: Floats, mass: Floats, fixed: Ints) -> float:
    """Lowest circular frequency [1/s] above the rigid-body modes, `fixed` dofs (2 * node + component) held.

    inf where every degree of freedom is held.
    """
    n, a = body.cells.shape
    dof = (2 * body.cells[:, :, None] + np.arange(2)).reshape(n, 2 * a)
    rows, columns = np.repeat(dof, 2 * a, axis=1).ravel(), np.tile(dof, (1, 2 * a)).ravel()
    size = 2 * len(positions)
    stiffness = coo_matrix((cell_stiffness(body, positions).ravel(), (rows, columns)), shape=(size, size)).tocsc()
    own = np.setdiff1d(np.unique(dof), fixed)
    if not len(own):
        return float("inf")
    scale = diags(1.0 / np.sqrt(np.repeat(mass, 2)[own]))
    scaled = scale @ stiffness[own][:, own] @ scale
    # a shift far below the first elastic mode keeps the matrix definite when rigid modes are left
    shift = 1e-9 * scaled.diagonal().min()
    wanted = min(4, len(own) - 1)
    if wanted < 1:
        return float(np.sqrt(scaled.diagonal().max()))
    values = eigsh(scaled, k=wanted, sigma=-shift, which="LM", return_eigenvectors=False, v0=np.ones(len(own)))
    elastic = values[values > 100.0 * shift]
    return float(np.sqrt(elastic.min())) if len(elastic) else float(np.sqrt(scaled.diagonal().min()))


def total_mass(body: Body) -> float:
    """Mass of a body [t]."""
    return float(cell_masses(body).sum())
