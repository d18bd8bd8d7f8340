"""Cell stiffness by differences, for elements whose kernels are their own.

All cells get nodes of their own, so that a perturbed force evaluation gives a column of the stiffness
of every cell: two evaluations for each degree of freedom of a cell, whatever the number of cells.

Only the element is differenced, being smooth; stresses change by the tangent of the law. A difference of stresses
would span both branches of a law at points that have flowed by less than its width, which is every point in a short
load step: the mean of elastic and plastic stiffness then makes Newton's iteration crawl.
"""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.kernels.cells import midpoint
from contactlab.model.bodies.body import Block, BodyForces
from contactlab.model.bodies.tangent import BodyStiffness, Pattern, scatter_all

STEP = 1e-6  # of a cell's size: central differences then err by about 1e-10 of the stiffness


class StiffnessByDifferences(BodyStiffness):
    """Stiffness of one body from forces of its own kernels on cells that share no nodes, by differences."""

    def __init__(self, forces: BodyForces) -> None:
        super().__init__(forces)
        self.law = forces.body.material

    def add(self, block: Block, dt: float, pairs: Ints, pattern: Pattern) -> None:
        """Add the block's cells to the pattern's data."""
        nodes, cells = block.connectivity.shape
        geometry, field = self._per_cell(self.forces.geometry, block), self._per_cell(self.forces.field, block)
        x = geometry.reshape(nodes, cells, 2)
        step = STEP * np.ptp(x, axis=0).max(axis=1)
        tangent = np.zeros((4, 4, block.stress.shape[1]))
        block.law.tangent(block.gradient, block.history, dt, tangent)
        matrices = np.empty((cells, 2 * nodes, 2 * nodes))
        for b in range(nodes):
            for k in range(2):
                high = self._forces(block, tangent, geometry, field, b, k, step)
                low = self._forces(block, tangent, geometry, field, b, k, -step)
                column = (high - low).reshape(nodes, cells, 2) / (2.0 * step[:, None])
                matrices[:, :, 2 * b + k] = column.transpose(1, 0, 2).reshape(cells, 2 * nodes)
        scatter_all(matrices, pairs, pattern.place, pattern.stride, pattern.data)

    def _per_cell(self, values: Floats, block: Block) -> Floats:
        """Return nodal values (a B, 2) of the block's cells, node by node."""
        return np.ascontiguousarray(values[block.connectivity].reshape(-1, 2))

    def _forces(
        self, block: Block, tangent: Floats, geometry: Floats, field: Floats, b: int, k: int, step: Floats
    ) -> Floats:
        """Return nodal forces (a B, 2) with node b of every cell moved by `step` (B,) along k."""
        nodes, cells = block.connectivity.shape
        connectivity = np.arange(nodes * cells, dtype=np.int32).reshape(nodes, cells)
        moved = slice(b * cells, (b + 1) * cells)
        kinematics = self.law.kinematics
        geometry, field = geometry.copy(), field.copy()
        if kinematics != "small":
            geometry[moved, k] += step
        if kinematics != "finite":
            field[moved, k] += step
        gradient, force, stabilise = self.forces.kernels
        strain, out = np.empty_like(block.gradient), np.zeros_like(geometry)
        scratch = np.zeros((6 * nodes + 6, cells))
        gradient(geometry, field, connectivity, strain, scratch)
        if kinematics == "rate":
            midpoint(strain)
        stress = block.stress + np.einsum("ijp,jp->ip", tangent, strain - block.gradient)
        force(geometry, connectivity, stress, out, scratch)
        if stabilise is not None and self.forces.shape is not None:
            reference, displacement = (self._per_cell(values, block) for values in self.forces.shape)
            displacement[moved, k] += step
            stabilise(reference, displacement, connectivity, self.forces.body.shear_modulus, out, scratch)
        return out
