"""Isotropic elastic stiffness of cells, for estimates: stable steps and lowest frequencies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.kernels.cells import element_kernels
from contactlab.meshing.mesh import cell_measures
from contactlab.model.bodies.body import Body

CHUNK = 1024  # cells whose stiffness is computed at a time

CellForces = Callable[[Floats, Floats, Ints, Floats, Floats], None]
"""(positions, displacement, connectivity, force, scratch): adds forces that are linear in the displacement."""


def cell_stiffness(body: Body, positions: Floats) -> Floats:
    """Return stiffness matrices (n, 2a, 2a) [N/mm] at `positions` (N, 2), moduli from the law's wave speeds.

    Column by column through the element's own kernels for small strains, so that averaged strains and
    stabilisation count as they do in a run.
    """
    kernels = element_kernels(body.element)
    shear, lame = body.shear_modulus, body.dilatational_modulus - 2.0 * body.shear_modulus

    def forces(x: Floats, u: Floats, conn: Ints, out: Floats, scratch: Floats) -> None:
        strain = np.empty((4, body.points * conn.shape[1]))
        kernels.gradient(x, u, conn, strain, scratch)
        kernels.force(x, conn, _hooke(strain, lame, shear), out, scratch)
        if kernels.stabilise is not None:
            kernels.stabilise(x, u, conn, shear, out, scratch)

    return _by_columns(body, positions, forces)


def _hooke(strain: Floats, lame: float, shear: float) -> Floats:
    """Return stress rows (4, P) from du/dx rows."""
    xx, xy, yx, yy = strain
    pressure = lame * (xx + yy)
    return np.stack([pressure + 2.0 * shear * xx, pressure + 2.0 * shear * yy, pressure, shear * (xy + yx)])


def _by_columns(body: Body, positions: Floats, forces: CellForces) -> Floats:
    """Return matrices (n, 2a, 2a) of linear cell forces, by unit displacements of cells that share no nodes."""
    n, a = body.cells.shape
    matrices = np.empty((n, a, 2, a, 2))
    for begin in range(0, n, CHUNK):
        cells = body.cells[begin : begin + CHUNK]
        size = len(cells)
        x = np.ascontiguousarray(positions[cells].transpose(1, 0, 2).reshape(-1, 2))
        conn = np.arange(a * size, dtype=np.int32).reshape(a, size)
        scratch = np.zeros((6 * a + 6, size))
        for b in range(a):
            for k in range(2):
                unit, out = np.zeros_like(x), np.zeros_like(x)
                unit[b * size : (b + 1) * size, k] = 1.0
                forces(x, unit, conn, out, scratch)
                matrices[begin : begin + size, :, :, b, k] = out.reshape(a, size, 2).transpose(1, 0, 2)
    return matrices.reshape(n, 2 * a, 2 * a)


def cell_masses(body: Body) -> Floats:
    """Return the lumped mass (n, a) [t] of each cell on its nodes."""
    return body.material.density * cell_measures(body.mesh, body.element)


def cell_frequencies(body: Body, positions: Floats, which: Ints | None = None) -> Floats:
    """Return the highest frequency [1/s] of each cell, or of cells `which`; their maximum bounds the whole."""
    which = np.arange(len(body.cells), dtype=np.int32) if which is None else which
    scale = 1.0 / np.sqrt(np.repeat(cell_masses(body)[which], 2, axis=1))
    highest = np.empty(len(which))
    for begin in range(0, len(which), CHUNK):
        part = slice(begin, begin + CHUNK)
        k = cell_stiffness(replace(body, cells=body.cells[which[part]]), positions)
        k *= scale[part, :, None] * scale[part, None, :]
        highest[part] = np.linalg.eigvalsh(k)[:, -1]
    return np.sqrt(np.maximum(highest, 0.0))
