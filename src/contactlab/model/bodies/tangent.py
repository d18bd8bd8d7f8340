"""The assembled stiffness: d(internal force)/d(displacement) of all bodies, for implicit integrators."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array

from contactlab.api import Floats, Ints
from contactlab.kernels import tangent as kernels
from contactlab.kernels.cells import table_kernels
from contactlab.model.bodies.body import Block, Body, BodyForces
from contactlab.model.bodies.element_differences import StiffnessByDifferences

KIND = {"small": kernels.SMALL, "finite": kernels.FINITE, "rate": kernels.RATE}


class Tangent:
    """Stiffness with one sparse pattern for the whole run; `assemble` renews the values."""

    def __init__(self, nodes: int, forces: tuple[BodyForces, ...]) -> None:
        self.pattern = Pattern(nodes, [block.connectivity for body in forces for block in body.blocks])
        self.bodies = tuple(
            BodyTangent(body) if follows_tables(body.body) else StiffnessByDifferences(body) for body in forces
        )

    def assemble(self, dt: float) -> csc_array:
        """Return stiffness (2N, 2N) at the last update of stresses, after a step `dt`; the same arrays every call."""
        self.pattern.data[:] = 0.0
        pairs = iter(self.pattern.pairs)
        for body in self.bodies:
            for block in body.forces.blocks:
                body.add(block, dt, next(pairs), self.pattern)
        return self.pattern.matrix


class Pattern:
    """Positions of the 2x2 entries of all pairs of nodes that share a cell in a matrix stored by columns."""

    def __init__(self, nodes: int, connectivities: list[Ints]) -> None:
        keys = [_pair_keys(connectivity, nodes) for connectivity in connectivities]
        found, number = np.unique(np.concatenate([key.ravel() for key in keys]), return_inverse=True)
        self.nodes, self.keys = nodes, found
        self.pairs = _split(number.astype(np.int32), [key.shape for key in keys])
        column, row = np.divmod(found, nodes)
        count = np.bincount(column, minlength=nodes)
        first = np.concatenate([[0], np.cumsum(count)])
        self.stride = (2 * count[column]).astype(np.int32)
        self.place = (4 * first[column] + 2 * (np.arange(len(found)) - first[column])).astype(np.int32)
        self.data: Floats = np.zeros(4 * len(found))
        index = np.empty(len(self.data), np.int32)
        for i in range(2):
            for k in range(2):
                index[self.place + i + k * self.stride] = 2 * row + i
        start = np.concatenate([[0], np.cumsum(np.repeat(2 * count, 2))]).astype(np.int32)
        self.matrix = csc_array((self.data, index, start), shape=(2 * nodes, 2 * nodes))
        # SciPy may copy its arguments
        self.data = self.matrix.data

    def place_of(self, row: Ints, column: Ints) -> Ints:
        """Return positions in the matrix's data of entries of these degrees of freedom, of nodes that share a cell."""
        (n, i), (m, k) = np.divmod(row, 2), np.divmod(column, 2)
        pair = np.searchsorted(self.keys, m.astype(np.int64) * self.nodes + n)
        place: Ints = self.place[pair] + i + k * self.stride[pair]
        return place


def _pair_keys(connectivity: Ints, nodes: int) -> Ints:
    """Return column * nodes + row of every pair of a block's cells (B, a, a), [cell, row, column]."""
    cells = connectivity.T.astype(np.int64)
    return cells[:, None, :] * nodes + cells[:, :, None]


def _split(number: Ints, shapes: list[tuple[int, ...]]) -> list[Ints]:
    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])[:-1]
    return [part.reshape(shape) for part, shape in zip(np.split(number, ends), shapes, strict=True)]


class BodyTangent:
    """Stiffness from the law's tangent and the element's tables."""

    def __init__(self, forces: BodyForces) -> None:
        self.forces, body = forces, forces.body
        self.kind = KIND[body.material.kinematics]
        rule = body.element.quadrature()
        self.derivatives = np.ascontiguousarray(body.element.shape(rule.points).gradient)
        self.weights = np.ascontiguousarray(rule.weights)
        points, nodes = max(block.stress.shape[1] for block in forces.blocks), body.cells.shape[1]
        self.tangent, self.modulus = np.zeros((4, 4, points)), np.zeros((4, 4, points))
        self.gradients, self.matrix = np.zeros((nodes + 1, 2)), np.zeros((2 * nodes, 2 * nodes))

    def add(self, block: Block, dt: float, pairs: Ints, pattern: Pattern) -> None:
        """Add the block's cells to the pattern's data."""
        points = block.stress.shape[1]
        whole = points == self.tangent.shape[2]
        tangent = self.tangent if whole else np.zeros((4, 4, points))
        modulus = self.modulus if whole else np.zeros((4, 4, points))
        block.law.tangent(block.gradient, block.history, dt, tangent)
        kernels.two_point_modulus(self.kind, block.gradient, block.stress, tangent, modulus)
        kernels.add_cells(
            self.forces.geometry, block.connectivity, self.derivatives, self.weights, modulus, pairs, pattern.place,
            pattern.stride, pattern.data, self.gradients, self.matrix,
        )  # fmt: skip


def follows_tables(body: Body) -> bool:
    """Return whether an element's own kernels agree with its tables, tested on one distorted cell.

    They may be the same element written faster, or a different element: F-bar, hourglass control.
    """
    element = body.element
    own = element.block_kernels(body.material.kinematics)
    if own is None:
        return True
    if own.stabilise is not None:
        return False
    generic, nodes = table_kernels(element), len(element.nodes)
    draw = np.random.default_rng(1)
    geometry = element.nodes + draw.uniform(-0.1, 0.1, (nodes, 2))
    field = element.nodes + draw.uniform(-0.1, 0.1, (nodes, 2))
    connectivity = np.arange(nodes, dtype=np.int32)[:, None]
    stress = draw.uniform(-1.0, 1.0, (4, len(element.quadrature().weights)))
    results = []
    for gradient, force, _ in (own, generic):
        out, nodal, scratch = np.zeros_like(stress), np.zeros((nodes, 2)), np.zeros((6 * nodes + 6, 1))
        gradient(geometry, field, connectivity, out, scratch)
        force(geometry, connectivity, stress, nodal, scratch)
        results.append(np.concatenate([out.ravel(), nodal.ravel()]))
    once, again = results
    return bool(np.allclose(once, again, rtol=0.0, atol=1e-12))
