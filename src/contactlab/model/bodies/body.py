"""A body: its blocks of cells and the calls that give stresses and internal forces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contactlab.api import BLOCK_CELLS, Element, Floats, Ints, Material, Mesh
from contactlab.kernels.cells import element_kernels, midpoint
from contactlab.kernels.size import jacobian_determinants
from contactlab.model.bodies.straight_path import StraightPath
from contactlab.model.bodies.thread_blocks import colours, threads_of_blocks


@dataclass(frozen=True)
class Body:
    """A body in global node numbers.

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

    def shape_gradients(self, points: Floats) -> Floats:
        """Return gradients (s, a, 2) of the shape functions at reference points (s, 2), kept for later frames."""
        key = points.tobytes()
        if key not in self._gradients:
            self._gradients[key] = np.ascontiguousarray(self.element.shape(points).gradient)
        return self._gradients[key]

    @cached_property
    def _gradients(self) -> dict[bytes, Floats]:
        return {}

    @cached_property
    def shear_modulus(self) -> float:
        """Shear modulus [MPa] of the undeformed material."""
        return float(self.material.density * self.material.wave_speeds()[1] ** 2)

    @cached_property
    def dilatational_modulus(self) -> float:
        """lambda + 2 mu [MPa] of the undeformed material."""
        return float(self.material.density * self.material.wave_speeds()[0] ** 2)

    def history_shape(self) -> tuple[int, ...]:
        """Shape of the body's history in the state: (n q h,)."""
        return (len(self.cells) * self.points * self.material.history_size,)


@dataclass(frozen=True)
class RigidSurface:
    """A chain in global node numbers, first ... first + count - 1, the solid on its left.

    points  (count, 2) [mm] before the run
    edges   (e, b) int32 global numbers, with as many nodes as the edges in contact with it
    """

    name: str
    points: Floats
    first: int
    edges: Ints

    @property
    def count(self) -> int:
        """Number of nodes of the rigid surface."""
        return len(self.points)

    @property
    def nodes(self) -> Ints:
        """Global numbers of the surface's nodes."""
        return np.arange(self.first, self.first + self.count, dtype=np.int32)


def positions_of(bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...]) -> Floats:
    """Return positions (N, 2) [mm] of all nodes before the run."""
    return np.concatenate([*(body.mesh.nodes for body in bodies), *(surface.points for surface in rigid)])


class Joints(NamedTuple):
    """Nodes tied to a point of an edge: u[node] = (1 - share) u[ends[0]] + share u[ends[1]].

    node (j,), ends (j, 2) node numbers; share (j,) from 0 to 1
    """

    node: Ints
    ends: Ints
    share: Floats


NO_JOINTS = Joints(np.zeros(0, np.int32), np.zeros((0, 2), np.int32), np.zeros(0))


@dataclass
class Block:
    """Arrays of one block of B cells; `stress` (4, P) and `gradient` (4, P) belong to the last update.

    Blocks may share these two: read them through `BodyForces.current`.
    `history` belongs to the last accepted step; `new_history` to the last update, the same array
    if every update is an accepted step. `law` gives stresses: the body's law, or its path through a step.
    """

    connectivity: Ints
    gradient: Floats
    stress: Floats
    history: Floats
    new_history: Floats
    law: Material | StraightPath


class BodyForces:
    """The staged work of one body, bound to the model's arrays once.

    geometry and field follow the law's kinematics: (X, u), (x, X) or (x, du). With
    `trial_history` updates are trials from `history` until they are accepted; explicit runs give none.
    `shape` is (X, u) for all kinematics, for elements that stabilise. `colours` and `block_threads` of the
    blocks: see `contactlab.model.bodies.thread_blocks`.
    """

    def __init__(
        self,
        body: Body,
        geometry: Floats,
        field: Floats,
        force: Floats,
        history: Floats,
        trial_history: Floats | None = None,
        shape: tuple[Floats, Floats] | None = None,
        threads: int = 1,
        first_thread: int = 0,
    ) -> None:
        self.body = body
        # the element's own (Q1: `contactlab_quads.q1_kernels`), or the generic ones of `contactlab.kernels.cells`
        self.kernels = element_kernels(body.element, body.material.kinematics)
        self.shape = shape
        self.geometry, self.field, self.force, self.history = geometry, field, force, history
        self.trial_history = history if trial_history is None else trial_history
        # implicit steps integrate such a law along the path of the deformation
        self.follows_paths = trial_history is not None and (
            body.material.implicit_euler and body.material.history_size > 0 and body.material.kinematics != "rate"
        )
        self.blocks = _blocks(body, history, self.trial_history, self.follows_paths)
        self.shares_gradient = trial_history is None and len(self.blocks) > 1
        self.shares_stress = self.shares_gradient and not body.material.history_size
        self.colours = colours([block.connectivity for block in self.blocks], len(force))
        self.block_threads = threads_of_blocks(self.colours, threads, first_thread)
        # Blocks of equal width on one thread share an array whose values can be recomputed: 128 bytes less to
        # move per Q1 cell and step for each of the two. A gradient follows from positions, a stress from the gradient
        # unless the law has a history.
        first: dict[tuple[int, ...], Block] = {}
        for block, thread in zip(self.blocks, self.block_threads, strict=True):
            like = first.setdefault((thread, *block.stress.shape), block)
            block.gradient = like.gradient if self.shares_gradient else block.gradient
            block.stress = like.stress if self.shares_stress else block.stress
        self.dt = 0.0
        self.scratch = _scratch(self.blocks, self.block_threads)
        self.calls: tuple[Callable[[float], None], ...] = tuple(
            self._bind(block, scratch) for block, scratch in zip(self.blocks, self.scratch, strict=True)
        )

    def _bind(self, block: Block, scratch: Floats) -> Callable[[float], None]:
        gradient, force, _ = self.kernels
        stress_of, rate = block.law.stress, self.body.material.kinematics == "rate"
        geometry, field, nodal = self.geometry, self.field, self.force
        conn, g, sigma = block.connectivity, block.gradient, block.stress
        history, new_history = block.history, block.new_history

        def update(dt: float) -> None:
            self.dt = dt
            gradient(geometry, field, conn, g, scratch)
            if rate:
                midpoint(g)
            stress_of(g, history, dt, sigma, new_history)  # the law's formula over all points, or its `stress_by_hand`
            force(geometry, conn, sigma, nodal, scratch)

        return update if self.kernels.stabilise is None else self._stabilised(update, conn, scratch)

    def _stabilised(self, update: Callable[[float], None], conn: Ints, scratch: Floats) -> Callable[[float], None]:
        stabilise, shear, nodal = self.kernels.stabilise, self.body.shear_modulus, self.force
        assert stabilise is not None
        assert self.shape is not None
        reference, displacement = self.shape

        def stabilised(dt: float) -> None:
            update(dt)
            stabilise(reference, displacement, conn, shear, nodal, scratch)

        return stabilised

    def begin_step(self) -> None:
        """Take the present positions as start of a step, from which flowing laws follow the deformation path."""
        for block, scratch in zip(self.blocks, self.scratch, strict=True):
            if isinstance(block.law, StraightPath):
                if block.law.start is None:
                    block.law.start = np.empty_like(block.gradient)
                self.kernels.gradient(self.geometry, self.field, block.connectivity, block.law.start, scratch)

    def accept(self) -> None:
        """Accept the history of the last update."""
        self.history[:] = self.trial_history
        for block in self.blocks:
            if isinstance(block.law, StraightPath):
                block.law.start = None

    def current(self) -> Iterator[Block]:
        """Yield the blocks with gradient and stress of the last update, each valid until the next."""
        yield from map(self.renewed, range(len(self.blocks)))

    def renewed(self, number: int) -> Block:
        """Return a block with gradient and stress of the last update, valid until the next call."""
        block = self.blocks[number]
        if self.shares_gradient:
            scratch = self.scratch[number]
            self.kernels.gradient(self.geometry, self.field, block.connectivity, block.gradient, scratch)
            if self.body.material.kinematics == "rate":
                midpoint(block.gradient)
        if self.shares_stress:
            self.body.material.stress(block.gradient, block.history, self.dt, block.stress, block.history)
        return block

    def stress(self) -> Floats:
        """Return Cauchy stress of the last update, (n, q, 4)."""
        q = self.body.points
        return np.concatenate([b.stress.reshape(4, q, -1).transpose(2, 1, 0).copy() for b in self.current()])

    def stored_energy(self) -> float:
        """Return the stored energy of the body [mJ] at the last update; NaN for laws without one."""
        if not self.body.material.has_energy:
            return float("nan")
        return self._integral(self.body.material.energy)

    def dissipated_energy(self) -> float:
        """Return the energy dissipated by the body's law [mJ], by its history; 0 for laws without dissipation."""
        if not self.body.material.history_size:
            return 0.0
        return self._integral(self.body.material.dissipation)

    def numerical_energy(self) -> float:
        """Return the energy [mJ] in modes that only the element's stabilisation resists."""
        if self.kernels.stabilise is None:
            return 0.0
        assert self.shape is not None
        reference, displacement = self.shape
        force = np.zeros_like(displacement)
        for block, scratch in zip(self.blocks, self.scratch, strict=True):
            self.kernels.stabilise(reference, displacement, block.connectivity, self.body.shear_modulus, force, scratch)
        return float(0.5 * np.vdot(displacement, force))

    def _integral(self, density: Callable[[Floats, Floats, Floats], None]) -> float:
        """Return the sum over points of a density of the law per volume, at the last update."""
        total = 0.0
        for block, volume in self.current_volumes():
            values = np.empty(block.stress.shape[1])
            density(block.gradient, block.new_history, values)
            total += float(values @ volume)
        return total

    def current_volumes(self) -> Iterator[tuple[Block, Floats]]:
        """Yield the blocks of `current`, each with the volume per thickness (P,) [mm2] of its points."""
        rule = self.body.element.quadrature()
        for block in self.current():
            yield block, self._volumes(block, rule.points, rule.weights)

    def _volumes(self, block: Block, points: Floats, weights: Floats) -> Floats:
        """Return the volume per thickness [mm2] of every point, point-major, as the law sees it.

        For "finite" laws undeformed volume times det F of the law's own gradient, which an element may
        have averaged (F-bar); otherwise in the geometry of the forces.
        """
        if self.body.material.kinematics != "finite":
            return (self.determinants(block, points) * weights[:, None]).ravel()
        g = block.gradient
        undeformed = self._determinants(self.field, block, points) * weights[:, None]
        return np.asarray(undeformed.ravel() / (g[0] * g[3] - g[1] * g[2]))

    def determinants(self, block: Block, points: Floats) -> Floats:
        """Return Jacobian determinants (q, B) of a block's cells in the geometry of the forces."""
        return self._determinants(self.geometry, block, points)

    def _determinants(self, positions: Floats, block: Block, points: Floats) -> Floats:
        derivatives = self.body.shape_gradients(points)
        out = np.empty((len(points), block.connectivity.shape[1]))
        jacobian_determinants(positions, block.connectivity, derivatives, out)
        return out


def _scratch(blocks: Sequence[Block], block_threads: Sequence[int]) -> list[Floats]:
    """Return scratch of every block; blocks of equal size and thread share it."""
    shared: dict[tuple[int, int], Floats] = {}
    for block, thread in zip(blocks, block_threads, strict=True):
        nodes, cells = block.connectivity.shape
        if (thread, cells) not in shared:
            shared[thread, cells] = np.zeros((6 * nodes + 6, cells))
    return [shared[thread, block.connectivity.shape[1]] for block, thread in zip(blocks, block_threads, strict=True)]


def block_size(cells: int) -> int:
    """Return the number of cells of every block but the last, at most BLOCK_CELLS.

    Rows of a block's arrays stand a block's width apart. Powers of two put all rows into the same few sets of
    the first-level cache (measured: three times slower); eight times an odd number puts each into its own.
    """
    number = -(-cells // (BLOCK_CELLS - 8))
    if number == 1 and cells % 256:
        return cells
    size = -(-cells // max(2, number))
    return 8 * (-(-size // 8) | 1)


def _blocks(body: Body, history: Floats, trial_history: Floats, follows_paths: bool) -> list[Block]:
    """Return cells cut into blocks of about BLOCK_CELLS, equal except for the last."""
    cells, q, h = body.cells, body.points, body.material.history_size
    size = block_size(len(cells))
    blocks, at = [], 0
    for begin in range(0, len(cells), size):
        connectivity = np.ascontiguousarray(cells[begin : begin + size].T)
        points = q * connectivity.shape[1]
        old, new = (values[at : at + h * points].reshape(h, points) for values in (history, trial_history))
        at += h * points
        law = StraightPath(body.material) if follows_paths else body.material
        blocks.append(Block(connectivity, np.zeros((4, points)), np.zeros((4, points)), old, new, law))
    return blocks
