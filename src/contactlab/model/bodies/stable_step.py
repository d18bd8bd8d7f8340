"""The explicit step limit, followed while the geometry changes (docs/theory/explicit-scheme.md)."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.kernels.size import inverse_size_squared
from contactlab.model.bodies.body import BodyForces
from contactlab.model.bodies.stiffness import cell_frequencies

DRIFT = 1.1  # change of a cell's size beyond which its frequency is recomputed instead of scaled


class StableStep:
    """2/w_max of one body: element eigenvalues, scaled by cell size and by the law's stiffening in between."""

    def __init__(self, forces: BodyForces, positions: Floats) -> None:
        self.forces, self.body = forces, forces.body
        self.moving = self.body.material.kinematics != "small"
        self.size, self.before = np.empty(len(self.body.cells)), np.empty(len(self.body.cells))
        self.frequency = cell_frequencies(self.body, positions)
        inverse_size_squared(positions, self.body.cells, self.before)
        self.cell, self.latest = 0, float("inf")

    def _refresh(self, positions: Floats, growth: Floats) -> None:
        """Recompute frequencies of the cells whose size has drifted."""
        drifted = np.flatnonzero((growth > DRIFT) | (growth < 1.0 / DRIFT)).astype(np.int32)
        if len(drifted):
            self.frequency[drifted] = cell_frequencies(self.body, positions, drifted)
            self.before[drifted] = self.size[drifted]
            growth[drifted] = 1.0

    def limit(self, positions: Floats) -> float:
        """Return the largest stable step [s] at `positions` (N, 2)."""
        if not self.moving:
            return self._found(self.frequency**2)
        inverse_size_squared(positions, self.body.cells, self.size)
        growth = self.size / self.before
        self._refresh(positions, growth)
        return self._found(self.frequency**2 * growth * self._stiffening())

    def _found(self, squares: Floats) -> float:
        """Return the limit from squared frequencies (n,), and store it and its place in `latest` and `cell`."""
        self.cell = int(np.argmax(squares))
        self.latest = float(2.0 / np.sqrt(squares[self.cell]))
        return self.latest

    def _stiffening(self) -> Floats:
        factors = []
        for block in self.forces.current():
            out = np.empty(block.stress.shape[1])
            self.body.material.stiffening(block.gradient, block.stress, out)
            factors.append(out.reshape(self.body.points, -1).max(axis=0))
        return np.concatenate(factors)
