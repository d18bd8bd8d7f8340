"""The assembled stiffness: d(internal force)/d(displacement) of all bodies, for implicit integrators.

A two-point modulus A (4, 4, P) says how the stress that acts through the fixed shape of a cell changes
with the gradient of a small displacement: rows ij and columns kl in the order xx, xy, yx, yy,

    K_(ai)(bk) = sum over points of weight * det * dN_a/dx_j A_ijkl dN_b/dx_l .

Kernels compute the moduli of the points, and scatter cells into the columns of the matrix.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from scipy.sparse import csc_array

from contactlab.api import Floats, Ints
from contactlab.api.compiled.kernel import kernel
from contactlab.kernels.cells import table_kernels
from contactlab.model.bodies.body import Block, Body, BodyForces

SMALL, FINITE, RATE = 0, 1, 2
KIND = {"small": SMALL, "finite": FINITE, "rate": RATE}

_ROW = (0, 3, 3, 1)  # row of the stress (xx, yy, zz, xy) for component ij = xx, xy, yx, yy


class Tangent:
    """Stiffness with one sparse pattern for the whole run; `assemble` renews the values."""

    def __init__(self, nodes: int, forces: tuple[BodyForces, ...]) -> None:
        self.pattern = Pattern(nodes, [block.connectivity for body in forces for block in body.blocks])
        self.bodies = tuple(body_tangent(body) for body in forces)

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


class BodyStiffness(ABC):
    """Stiffness of one body."""

    def __init__(self, forces: BodyForces) -> None:
        self.forces = forces

    @abstractmethod
    def add(self, block: Block, dt: float, pairs: Ints, pattern: Pattern) -> None:
        """Add the block's cells to the pattern's data."""


class BodyTangent(BodyStiffness):
    """Stiffness from the law's tangent and the element's tables."""

    def __init__(self, forces: BodyForces) -> None:
        super().__init__(forces)
        body = forces.body
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
        two_point_modulus(self.kind, block.gradient, block.stress, tangent, modulus)
        add_cells(
            self.forces.geometry, block.connectivity, self.derivatives, self.weights, modulus, pairs, pattern.place,
            pattern.stride, pattern.data, self.gradients, self.matrix,
        )  # fmt: skip


def body_tangent(forces: BodyForces) -> BodyStiffness:
    """Return the stiffness of a body, by differences if its element's kernels are not its tables written faster."""
    if follows_tables(forces.body):
        return BodyTangent(forces)
    from contactlab.model.bodies.element_differences import StiffnessByDifferences

    return StiffnessByDifferences(forces)


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


# --- kernels --------------------------------------------------------------------------------------------------------


@kernel
def two_point_modulus(kind: int, gradient: Floats, stress: Floats, tangent: Floats, out: Floats) -> None:
    """Fill modulus A (4, 4, P) from a law's tangent (4, 4, P), with the geometric part from the stress.

    small   gradient of u by X: the tangent itself
    finite  gradient g of X by x: d g = -g grad(du)
    rate    increment L at mid-step: d L = (I - L/2) grad(du) (I + L/2)
    The last two act on the current geometry: A_ijkl += s_ij delta_kl - s_il delta_jk.
    """
    for p in range(gradient.shape[1]):
        xx, xy, yx, yy = gradient[0, p], gradient[1, p], gradient[2, p], gradient[3, p]
        for r in range(4):
            s = _ROW[r]
            a, b, c, d = tangent[s, 0, p], tangent[s, 1, p], tangent[s, 2, p], tangent[s, 3, p]
            if kind == FINITE:
                out[r, 0, p], out[r, 1, p] = -(a * xx + c * yx), -(b * xx + d * yx)
                out[r, 2, p], out[r, 3, p] = -(a * xy + c * yy), -(b * xy + d * yy)
            elif kind == RATE:
                # rows of (I - L/2)^T applied from the left, of (I + L/2)^T from the right
                e, f = (1.0 - 0.5 * xx) * a - 0.5 * yx * c, (1.0 - 0.5 * xx) * b - 0.5 * yx * d
                g, h = (1.0 - 0.5 * yy) * c - 0.5 * xy * a, (1.0 - 0.5 * yy) * d - 0.5 * xy * b
                out[r, 0, p], out[r, 1, p] = e * (1.0 + 0.5 * xx) + f * 0.5 * xy, e * 0.5 * yx + f * (1.0 + 0.5 * yy)
                out[r, 2, p], out[r, 3, p] = g * (1.0 + 0.5 * xx) + h * 0.5 * xy, g * 0.5 * yx + h * (1.0 + 0.5 * yy)
            else:
                out[r, 0, p], out[r, 1, p], out[r, 2, p], out[r, 3, p] = a, b, c, d
        if kind == SMALL:
            continue
        s_xx, s_yy, s_xy = stress[0, p], stress[1, p], stress[3, p]
        out[0, 1, p] -= s_xy
        out[0, 3, p] += s_xx
        out[1, 0, p] += s_xy
        out[1, 2, p] -= s_xx
        out[2, 1, p] -= s_yy
        out[2, 3, p] += s_xy
        out[3, 0, p] += s_yy
        out[3, 2, p] -= s_xy


@kernel
def add_cells(
    geometry: Floats, connectivity: Ints, derivatives: Floats, weights: Floats, modulus: Floats, pairs: Ints,
    place: Ints, stride: Ints, data: Floats, gradients: Floats, matrix: Floats,
) -> None:  # fmt: skip
    """Add the stiffness of a block of cells to `data`, the values of a sparse matrix by columns.

    geometry (N, 2), connectivity (a, B), derivatives (q, a, 2), modulus (4, 4, q B), pairs (B, a, a) numbers of
    the node pairs; a pair's 2x2 entries (i, k) stand at place[pair] + i + k * stride[pair].
    `gradients` (a + 1, 2) and `matrix` (2a, 2a) are scratch.
    """
    nodes, cells = connectivity.shape
    for c in range(cells):
        for i in range(2 * nodes):
            for k in range(2 * nodes):
                matrix[i, k] = 0.0
        for g in range(derivatives.shape[0]):
            _gradients_at(geometry, connectivity, c, derivatives[g], gradients)
            _add_point(gradients, weights[g] * gradients[nodes, 0], modulus, g * cells + c, nodes, matrix)
        scatter(matrix, pairs[c], place, stride, data)


@kernel
def _gradients_at(geometry: Floats, connectivity: Ints, c: int, parent: Floats, gradients: Floats) -> None:
    """Compute gradients of the shape functions of cell c into gradients[:a]; the determinant into gradients[a, 0]."""
    nodes = connectivity.shape[0]
    x_xi, x_eta, y_xi, y_eta = 0.0, 0.0, 0.0, 0.0
    for a in range(nodes):
        x, y = geometry[connectivity[a, c], 0], geometry[connectivity[a, c], 1]
        x_xi += parent[a, 0] * x
        x_eta += parent[a, 1] * x
        y_xi += parent[a, 0] * y
        y_eta += parent[a, 1] * y
    det = x_xi * y_eta - x_eta * y_xi
    for a in range(nodes):
        gradients[a, 0] = (parent[a, 0] * y_eta - parent[a, 1] * y_xi) / det
        gradients[a, 1] = (parent[a, 1] * x_xi - parent[a, 0] * x_eta) / det
    gradients[nodes, 0] = det


@kernel
def _add_point(gradients: Floats, volume: float, modulus: Floats, p: int, nodes: int, matrix: Floats) -> None:
    for b in range(nodes):
        bx, by = volume * gradients[b, 0], volume * gradients[b, 1]
        for k in range(2):
            xx = modulus[0, 2 * k, p] * bx + modulus[0, 2 * k + 1, p] * by
            xy = modulus[1, 2 * k, p] * bx + modulus[1, 2 * k + 1, p] * by
            yx = modulus[2, 2 * k, p] * bx + modulus[2, 2 * k + 1, p] * by
            yy = modulus[3, 2 * k, p] * bx + modulus[3, 2 * k + 1, p] * by
            for a in range(nodes):
                matrix[2 * a, 2 * b + k] += gradients[a, 0] * xx + gradients[a, 1] * xy
                matrix[2 * a + 1, 2 * b + k] += gradients[a, 0] * yx + gradients[a, 1] * yy


@kernel
def scatter(matrix: Floats, pairs: Ints, place: Ints, stride: Ints, data: Floats) -> None:
    """Add one cell's matrix (2a, 2a) to the columns; pairs (a, a) of row and column node."""
    nodes = pairs.shape[0]
    for a in range(nodes):
        for b in range(nodes):
            at, step = place[pairs[a, b]], stride[pairs[a, b]]
            for i in range(2):
                for k in range(2):
                    data[at + i + k * step] += matrix[2 * a + i, 2 * b + k]


@kernel
def scatter_all(matrices: Floats, pairs: Ints, place: Ints, stride: Ints, data: Floats) -> None:
    """Call `scatter` for all cells (B, 2a, 2a)."""
    for c in range(matrices.shape[0]):
        scatter(matrices[c], pairs[c], place, stride, data)
