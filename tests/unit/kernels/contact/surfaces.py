"""Surfaces, contributions and couplings to try kernels of contact on, and what they are as dense matrices."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.kernels.contact import coupling
from contactlab.kernels.contact.coupling import Coupling
from contactlab.meshing.mesh import surface_from_edges


def chain(nodes: int, closed: bool = False) -> Surface:
    """A chain of straight edges through nodes 0, 1, ..."""
    ends = np.arange(nodes if closed else nodes - 1)
    return surface_from_edges(np.stack([ends, (ends + 1) % nodes], axis=1).astype(np.int32))


def contributions(surface: Surface, covered: Floats, seed: int = 1) -> tuple[Ints, Floats]:
    """Multipliers (p, 2) and positive T (p, 2, 2), diagonally dominant, of segments that are covered by a share."""
    draw = np.random.default_rng(seed)
    used = np.flatnonzero(covered > 0.0)
    T = draw.uniform(0.1, 0.3, (len(used), 2, 2)) + 0.7 * np.eye(2)
    return np.ascontiguousarray(surface.segments[used]), np.ascontiguousarray(covered[used, None, None] * T)


def coupled(surface: Surface, multiplier: Ints, T: Floats, full: float = 1.0, fixed: tuple[int, ...] = ()) -> Coupling:
    """The coupling that kernels make of these contributions."""
    held = np.zeros(len(surface.nodes), np.bool_)
    held[list(fixed)] = True
    found = Coupling(surface, 1, np.ones(len(surface.nodes), np.bool_), held)
    found.full[:] = full
    coupling.couple(len(multiplier), multiplier, T, found.table)
    return found


def dense_coupling(found: Coupling, multiplier: Ints, T: Floats) -> Floats:
    """T (k, k) with the rows and columns of merged multipliers added to their owners', the identity where none is."""
    k = len(found.owner)
    matrix = np.zeros((k, k))
    for p in range(len(multiplier)):
        for i, row in enumerate(found.owner[multiplier[p]]):
            for j, column in enumerate(found.owner[multiplier[p]]):
                if row >= 0 and column >= 0:
                    matrix[row, column] += T[p, i, j]
    gone = np.setdiff1d(np.arange(k), found.order)
    matrix[gone, gone] = 1.0
    return matrix
