"""Cells to try an element on: stretched, turned and distorted, with the element's own nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from contactlab.api import BlockKernels, Element, Floats, Ints, Kinematics, Mesh
from contactlab.kernels.cells import element_kernels

LAME, SHEAR = 1.5, 1.0  # of Hooke's law in checks; any positive pair serves


@dataclass
class Cells:
    """n separate cells of one element: nodes (n a, 2), connectivity (a, n), and whose kernels are used."""

    element: Element
    nodes: Floats
    connectivity: Ints
    kinematics: Kinematics = "small"

    @property
    def mesh(self) -> Mesh:
        """The cells as a mesh without edge sets."""
        return Mesh(self.nodes, np.ascontiguousarray(self.connectivity.T), {})

    def part(self, begin: int, end: int) -> Cells:
        """Cells begin ... end - 1, with the nodes of all."""
        return replace(self, connectivity=np.ascontiguousarray(self.connectivity[:, begin:end]))

    def gradient(self, field: Floats) -> Floats:
        """Derivative d(field)/d(position) (4, P) of nodal values."""
        return self._gradient_and_scratch(field)[0]

    def force(self, stress: Floats) -> Floats:
        """Nodal forces (N, 2) of a stress (4, P)."""
        force = np.zeros_like(self.nodes)
        self.add_force(stress, force)
        return force

    def add_force(self, stress: Floats, force: Floats) -> None:
        """Add the nodal forces of a stress (4, P) to `force` (N, 2)."""
        _, scratch = self._gradient_and_scratch(self.nodes)
        self.kernels.force(self.nodes, self.connectivity, stress, force, scratch)

    def stabilising_force(self, displacement: Floats) -> Floats:
        """Nodal forces (N, 2) that give stiffness to modes which the points do not see; zero for most elements."""
        force = np.zeros_like(self.nodes)
        if self.kernels.stabilise is not None:
            a, n = self.connectivity.shape
            scratch, u = np.zeros((6 * a + 6, n)), np.ascontiguousarray(displacement)
            self.kernels.stabilise(self.nodes, u, self.connectivity, SHEAR, force, scratch)
        return force

    @property
    def kernels(self) -> BlockKernels:
        """The element's kernels for these kinematics."""
        return element_kernels(self.element, self.kinematics)

    def _gradient_and_scratch(self, field: Floats) -> tuple[Floats, Floats]:
        a, n = self.connectivity.shape
        scratch = np.zeros((6 * a + 6, n))
        out = np.full((4, self.points), np.nan)
        self.kernels.gradient(self.nodes, np.ascontiguousarray(field), self.connectivity, out, scratch)
        return out, scratch

    @property
    def points(self) -> int:
        """Number of points of all cells."""
        return len(self.element.quadrature().weights) * int(self.connectivity.shape[1])


def distorted_cells(
    element: Element, count: int, *, wobble: float = 0.08, seed: int = 1, kinematics: Kinematics = "small"
) -> Cells:
    """Cells with random aspect up to 2, any orientation, and nodes off their place by `wobble` of the half side."""
    rng = np.random.default_rng(seed)
    a = len(element.nodes)
    x = element.nodes[None] + wobble * rng.uniform(-1.0, 1.0, (count, a, 2))
    x = x * rng.uniform(0.5, 1.0, (count, 1, 2))
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=-1).reshape(-1, 2, 2)
    x = np.einsum("nij,naj->nai", turn, x) + rng.uniform(-5.0, 5.0, (count, 1, 2))
    connectivity = np.arange(count * a, dtype=np.int32).reshape(count, a).T.copy()
    return Cells(element, np.ascontiguousarray(x.reshape(-1, 2)), connectivity, kinematics)


def hooke(gradient: Floats) -> Floats:
    """Stress rows (4, P) of Hooke's law with `LAME` and `SHEAR` from du/dX rows."""
    xx, xy, yx, yy = gradient
    pressure = LAME * (xx + yy)
    return np.stack([pressure + 2.0 * SHEAR * xx, pressure + 2.0 * SHEAR * yy, pressure, SHEAR * (xy + yx)])


def cell_stiffness(cell: Cells) -> Floats:
    """Stiffness (2a, 2a) of a single cell, column by column through the element's own kernels."""
    size = 2 * len(cell.nodes)
    columns = []
    for j in range(size):
        unit = np.zeros(size)
        unit[j] = 1.0
        displacement = unit.reshape(-1, 2)
        force = cell.force(hooke(cell.gradient(displacement))) + cell.stabilising_force(displacement)
        columns.append(force.ravel())
    return np.stack(columns, axis=1)


def gauss(order: int = 8) -> tuple[Floats, Floats]:
    """Points (q, 2) and weights (q,) of a fine Gauss rule on the reference square, exact to degree 2 order - 1."""
    x, w = np.polynomial.legendre.leggauss(order)
    return np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(w, w).ravel()
