"""A body: its blocks of cells and the calls that give stresses and internal forces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactlab.api import BLOCK_CELLS, Element, Floats, Ints, Material, Mesh
from contactlab.kernels.cells import element_kernels, midpoint


@dataclass(frozen=True)
class Body:
    """One body in global node numbers.

    first, count  its nodes are first ... first + count - 1
    cells         (n, a) int32 global node numbers
    mesh          with local numbers, after rotation and shift
    """

    name: str
    element: Element
    material: Material
    mesh: Mesh
    first: int
    count: int
    cells: Ints

    @property
    def points(self) -> int:
        """Quadrature points per cell."""
        return len(self.element.quadrature().weights)

    def history_shape(self) -> tuple[int, ...]:
        """Shape of the body's history in the state: (n q h,)."""
        return (len(self.cells) * self.points * self.material.history_size,)


@dataclass
class Block:
    """Arrays of one block of B cells; `stress` (4, P) and `gradient` (4, P) are those of the last update."""

    connectivity: Ints
    gradient: Floats
    stress: Floats
    history: Floats


class BodyForces:
    """The staged work of one body, bound to the model's arrays once.

    geometry and field are what the law's kinematics asks for: (X, u), (x, X) or (x, du).
    """

    def __init__(self, body: Body, geometry: Floats, field: Floats, force: Floats, history: Floats) -> None:
        self.body = body
        self.kernels = element_kernels(body.element)
        self.geometry, self.field, self.force, self.history = geometry, field, force, history
        self.blocks = _blocks(body, history)
        cells = max(block.connectivity.shape[1] for block in self.blocks)
        self.scratch = [self._scratch_for(block, cells) for block in self.blocks]
        self.calls: tuple[Callable[[float], None], ...] = tuple(
            self._bind(block, scratch) for block, scratch in zip(self.blocks, self.scratch, strict=True)
        )

    def _scratch_for(self, block: Block, cells: int) -> Floats:
        """All full blocks share one scratch; the last, shorter one has its own."""
        nodes, size = block.connectivity.shape
        if size == cells:
            if not hasattr(self, "_shared"):
                self._shared = np.zeros((6 * nodes + 6, cells))
            return self._shared
        return np.zeros((6 * nodes + 6, size))

    def _bind(self, block: Block, scratch: Floats) -> Callable[[float], None]:
        gradient, force = self.kernels
        stress_of, rate = self.body.material.stress, self.body.material.kinematics == "rate"
        geometry, field, nodal = self.geometry, self.field, self.force
        conn, g, sigma, history = block.connectivity, block.gradient, block.stress, block.history

        def update(dt: float) -> None:
            gradient(geometry, field, conn, g, scratch)
            if rate:
                midpoint(g)
            stress_of(g, history, dt, sigma, history)
            force(geometry, conn, sigma, nodal, scratch)

        return update

    def stress(self) -> Floats:
        """Cauchy stress of the last update, (n, q, 4)."""
        q = self.body.points
        parts = [b.stress.reshape(4, q, -1).transpose(2, 1, 0) for b in self.blocks]
        return np.concatenate(parts)

    def stored_energy(self) -> float:
        """Stored energy of the body [mJ] at the last update; nan for laws without one."""
        if not self.body.material.has_energy:
            return float("nan")
        rule = self.body.element.quadrature()
        total = 0.0
        for block in self.blocks:
            energy = np.empty(block.stress.shape[1])
            self.body.material.energy(block.gradient, block.history, energy)
            total += float(energy @ self._volumes(block, rule.points, rule.weights))
        return total

    def _volumes(self, block: Block, points: Floats, weights: Floats) -> Floats:
        """Area of every point [mm2] in the geometry the forces act on, point-major."""
        return (self.determinants(block, points) * weights[:, None]).ravel()

    def determinants(self, block: Block, points: Floats) -> Floats:
        """Jacobian determinants (q, B) of a block's cells in the geometry the forces act on."""
        slopes = self.body.element.shape(points).gradient
        j = np.einsum("qai,abj->qbij", slopes, self.geometry[block.connectivity])
        return np.asarray(j[..., 0, 0] * j[..., 1, 1] - j[..., 0, 1] * j[..., 1, 0])


def _blocks(body: Body, history: Floats) -> list[Block]:
    """Cells cut into blocks of about BLOCK_CELLS, equal but for the last."""
    cells, q, h = body.cells, body.points, body.material.history_size
    number = -(-len(cells) // BLOCK_CELLS)
    size = -(-len(cells) // number)
    blocks, at = [], 0
    for begin in range(0, len(cells), size):
        connectivity = np.ascontiguousarray(cells[begin : begin + size].T)
        points = q * connectivity.shape[1]
        view = history[at : at + h * points].reshape(h, points)
        at += h * points
        blocks.append(Block(connectivity, np.zeros((4, points)), np.zeros((4, points)), view))
    return blocks
