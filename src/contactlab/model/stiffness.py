"""Isotropic elastic stiffness of cells, for estimates: stable steps and lowest frequencies."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.mesh import cell_measures
from contactlab.model.body import Body


def cell_stiffness(body: Body, positions: Floats) -> Floats:
    """Stiffness matrices (n, 2a, 2a) [N/mm] at `positions` (N, 2), moduli from the law's wave speeds."""
    rule = body.element.quadrature()
    slopes = body.element.shape(rule.points).gradient
    x = positions[body.cells]
    j = np.einsum("qai,naj->nqji", slopes, x)
    inverse = np.linalg.inv(j)
    gradient = np.einsum("qai,nqij->nqaj", slopes, inverse)
    weight = np.abs(np.linalg.det(j)) * rule.weights
    dilatational, shear = (body.material.density * c * c for c in body.material.wave_speeds())
    n, a = body.cells.shape
    k = np.empty((n, a, 2, a, 2))
    outer = np.einsum("nq,nqai,nqbj->naibj", weight, gradient, gradient)
    # C_ijkl = lambda d_ij d_kl + mu (d_ik d_jl + d_il d_jk)
    k[:] = (dilatational - 2.0 * shear) * outer
    k += shear * outer.transpose(0, 1, 4, 3, 2)
    trace = shear * np.einsum("naibi->nab", outer)
    for i in range(2):
        k[:, :, i, :, i] += trace
    return k.reshape(n, 2 * a, 2 * a)


def cell_masses(body: Body) -> Floats:
    """Lumped mass (n, a) [t] that each cell gives to its nodes."""
    return body.material.density * cell_measures(body.mesh, body.element)


def cell_frequencies(body: Body, positions: Floats) -> Floats:
    """Highest circular frequency (n,) [1/s] of each cell alone; their maximum bounds the assembly's."""
    highest = np.empty(len(body.cells))
    scale = 1.0 / np.sqrt(np.repeat(cell_masses(body), 2, axis=1))
    for begin in range(0, len(highest), 4096):
        part = slice(begin, begin + 4096)
        some = Body(body.name, body.element, body.material, body.mesh, body.first, body.count, body.cells[part])
        k = cell_stiffness(some, positions) * scale[part, :, None] * scale[part, None, :]
        highest[part] = np.linalg.eigvalsh(k)[:, -1]
    return np.sqrt(np.maximum(highest, 0.0))
