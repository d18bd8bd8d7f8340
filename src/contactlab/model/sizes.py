"""How large a scene will be, before anything is allocated for it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Element, ExplicitIntegrator, Material
from contactlab.errors import SceneError
from contactlab.meshing.room import NODE_BYTES, in_gib, machine_memory

if TYPE_CHECKING:
    from contactlab.errors import Location
    from contactlab.model.bodies.body import Body
    from contactlab.parts.registry import Registry
    from contactlab.scene.scene import Scene

FACTOR_BYTES = 800.0  # of an implicit model, per node and doubling of nodes: factors of its matrices grow as n log n
DENSER = 1.4  # times as much with elements that have more nodes than corners: a node has more neighbours
SEGMENT_BYTES = 200.0  # of a rigid surface: positions, edges and what a contact keeps for each
FRAME_BYTES = 12.0  # that a frame keeps in memory until the run ends, per node: positions and a value to show
THREADS_PER_CORE = 4
FEWER = "fewer cells, a smaller level, or longer segments"


@dataclass
class ModelSize:
    """What decides how much memory a model takes.

    implicit  whether matrices are factorised; dense: whether elements have more nodes than corners
    history   numbers that materials remember at all points
    """

    implicit: bool
    nodes: float = 0.0
    history: float = 0.0
    dense: bool = False

    def add(self, cells: float, element: type[Element], material: type[Material]) -> None:
        """A body of so many cells more."""
        corner, side, all_nodes = 4, sum(len(edge) - 2 for edge in element.edges), len(element.nodes)
        self.nodes += cells * (1.0 + side / 2.0 + (all_nodes - corner - side))  # sides and corners are shared
        self.history += cells * all_nodes * material.history_size
        self.dense = self.dense or all_nodes > corner

    @property
    def bytes(self) -> float:
        """As measured, to a factor of 2 (docs/reliability.md): what conditions of a contact keep is not counted."""
        factors = FACTOR_BYTES * math.log2(max(self.nodes, 1.0)) if self.implicit else 0.0
        return self.nodes * (NODE_BYTES + (DENSER if self.dense else 1.0) * factors) + 16.0 * self.history

    @property
    def words(self) -> str:
        """What takes the memory."""
        return f"{self.nodes:.3g} nodes so far{', with matrices of all of them' if self.implicit else ''}"


def check_sizes(scene: Scene, registry: Registry) -> None:
    """Raise SceneError, with key, estimate and limit, for what cannot fit into this machine."""
    most = THREADS_PER_CORE * (os.cpu_count() or 1)
    if scene.threads > most:
        raise SceneError(
            "more threads than would ever help",
            where=scene.where("threads"),
            got=scene.threads,
            allowed=f"at most {most}: {THREADS_PER_CORE} for each core of this machine",
        )
    size = _no_nodes(scene, registry)
    for name, body in scene.bodies.items():
        _add(size, scene, registry, name, _cells(body.mesh, scene.level))
        got = f"{body.mesh.get('cells')} at level {scene.level}, {size.words}"
        _fits(size.bytes, scene.where(f"bodies.{name}.mesh.cells"), got)


def check_meshed_size(scene: Scene, registry: Registry, bodies: Sequence[Body]) -> None:
    """The same once there are meshes: from a file, or of a kind whose `cells` are not all of its cells."""
    size = _no_nodes(scene, registry)
    for body in bodies:
        _add(size, scene, registry, body.name, len(body.cells))
        _fits(size.bytes, scene.where(f"bodies.{body.name}.mesh"), f"{len(body.cells)} cells, {size.words}")


def estimated_bytes(scene: Scene, registry: Registry, cells: Mapping[str, int] | None = None) -> float:
    """Bytes that the model of a scene will take, with so many cells in its bodies, or as many as it says."""
    size = _no_nodes(scene, registry)
    for name, body in scene.bodies.items():
        _add(size, scene, registry, name, cells[name] if cells is not None else _cells(body.mesh, scene.level))
    return size.bytes


def check_frame_size(frames: int, nodes: int, where: Location) -> None:
    """Raise SceneError where the stored frames of a run are more than this machine can hold.

    frames  that will be stored at most: as many as the scene asks for, but no more than steps
    """
    _fits(FRAME_BYTES * frames * nodes, where, f"{frames} frames of {nodes} nodes", "fewer frames, or a coarser mesh")


def check_rigid_size(points: float, where: Location, segment: float) -> None:
    """Raise SceneError where a rigid surface has more segments than this machine can hold."""
    _fits(SEGMENT_BYTES * points, where, f"{points:.3g} segments of {segment:.3g} mm")


def _fits(size: float, where: Location, got: str, hint: str = FEWER) -> None:
    limit = machine_memory()
    if size > limit:
        raise SceneError(
            "this needs more memory than there is",
            where=where,
            got=f"{got}: about {in_gib(size)}",
            allowed=f"what fits into {in_gib(limit)}",
            hint=hint,
        )


def _no_nodes(scene: Scene, registry: Registry) -> ModelSize:
    integrator = registry.part_class("integrator", scene.integrator["use"], scene.where("integrator"))
    return ModelSize(implicit=not issubclass(integrator, ExplicitIntegrator))


def _add(size: ModelSize, scene: Scene, registry: Registry, name: str, cells: float) -> None:
    body = scene.bodies[name]
    element = registry.part_class("element", body.element["use"], scene.where(f"bodies.{name}.element"))
    law = registry.part_class(
        "material", scene.materials[body.material]["use"], scene.where(f"materials.{body.material}")
    )
    size.add(cells, element, law)


def _cells(mesh: Mapping[str, Any], level: int) -> float:
    """Cells of a mesh that says their number, at a level; 0 for others."""
    counts = mesh.get("cells")
    if not isinstance(counts, list | tuple) or not counts:
        return 0.0
    return math.prod(_sum(count) * float(level) for count in counts)


def _sum(count: Any) -> float:
    if isinstance(count, list | tuple):
        return sum(_sum(part) for part in count)
    return float(count) if isinstance(count, int | float | np.integer) and not isinstance(count, bool) else 0.0
