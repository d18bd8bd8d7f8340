"""Size of a scene, before anything is allocated for it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from contactlab.api import ExplicitIntegrator
from contactlab.errors import Location, SceneError
from contactlab.meshing.room import in_words, machine_memory
from contactlab.model.bodies.body import Body
from contactlab.model.model_size import ModelSize
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

SEGMENT_BYTES = 200.0  # of a rigid surface: positions, edges and contact data for each
FRAME_BYTES = 12.0  # that a frame keeps in memory until the run ends, per node: positions and a value to show
THREADS_PER_CORE = 4
FEWER = "fewer cells, a smaller level, or longer segments"


def check_sizes(scene: Scene, registry: Registry) -> None:
    """Raise SceneError, with key, estimate and limit, for a scene too large for this machine."""
    most = THREADS_PER_CORE * (os.cpu_count() or 1)
    if scene.threads > most:
        raise SceneError(
            "more threads than would ever help",
            where=scene.where("threads"),
            got=scene.threads,
            allowed=f"at most {most}: {THREADS_PER_CORE} for each core of this machine",
        )
    size, slaves = _no_nodes(scene, registry), _slaves(scene)
    for name, body in scene.bodies.items():
        _add(size, scene, registry, slaves, name, _cells(body.mesh, scene.level), _sides(body.mesh, scene.level))
        got = f"{body.mesh.get('cells')} at level {scene.level}, {size.words}"
        _fits(size.bytes, scene.where(f"bodies.{name}.mesh.cells"), got)


def check_meshed_size(scene: Scene, registry: Registry, bodies: Sequence[Body]) -> None:
    """Check sizes again once meshes exist: from a file, or of a kind whose `cells` are not all of its cells."""
    size, slaves = _no_nodes(scene, registry), _slaves(scene)
    for body in bodies:
        _add(size, scene, registry, slaves, body.name, len(body.cells), _edges(body))
        _fits(size.bytes, scene.where(f"bodies.{body.name}.mesh"), f"{len(body.cells)} cells, {size.words}")


def estimated_bytes(scene: Scene, registry: Registry, cells: Mapping[str, int] | None = None) -> float:
    """Return bytes of the model of a scene, with `cells` in its bodies, or as many as the scene gives."""
    size, slaves = _no_nodes(scene, registry), _slaves(scene)
    for name, body in scene.bodies.items():
        number = _cells(body.mesh, scene.level) if cells is None else cells[name]
        _add(size, scene, registry, slaves, name, number, _sides(body.mesh, scene.level))
    return size.bytes


def check_frame_size(frames: int, nodes: int, where: Location) -> None:
    """Raise SceneError if the stored frames of a run exceed the memory of this machine.

    frames  upper limit of stored frames: as many as the scene asks for, but no more than steps
    """
    _fits(FRAME_BYTES * frames * nodes, where, f"{frames} frames of {nodes} nodes", "fewer frames, or a coarser mesh")


def check_rigid_size(points: float, where: Location, segment: float) -> None:
    """Raise SceneError if a rigid surface has more segments than this machine can hold."""
    _fits(SEGMENT_BYTES * points, where, f"{points:.3g} segments of {segment:.3g} mm")


def _fits(size: float, where: Location, got: str, hint: str = FEWER) -> None:
    limit = machine_memory()
    if size > limit:
        raise SceneError(
            "this needs more memory than there is",
            where=where,
            got=f"{got}: about {in_words(size)}",
            allowed=f"what fits into {in_words(limit)}",
            hint=hint,
        )


def _no_nodes(scene: Scene, registry: Registry) -> ModelSize:
    integrator = registry.part_class("integrator", scene.integrator["use"], scene.where("integrator"))
    # the loading time of a quasi-static run depends on the lowest frequency
    return ModelSize(not issubclass(integrator, ExplicitIntegrator), scene.time.end == "auto", scene.threads)


Slaves = Mapping[str, list[tuple[str, bool]]]
"""Slave edge sets of each body, True with friction."""


def _slaves(scene: Scene) -> Slaves:
    found: dict[str, list[tuple[str, bool]]] = {}
    for contact in scene.contacts:
        for target in contact.targets[0]:
            body, _, edge_set = target.partition(".")
            found.setdefault(body, []).append((edge_set, contact.friction is not None))
    return found


def _add(
    size: ModelSize,
    scene: Scene,
    registry: Registry,
    slaves: Slaves,
    name: str,
    cells: float,
    edges: Callable[[str], float],
) -> None:
    """Add a body of `cells` cells, with `edges` of cells in each of its edge sets."""
    body = scene.bodies[name]
    element = registry.part_class("element", body.element["use"], scene.where(f"bodies.{name}.element"))
    law = registry.part_class(
        "material", scene.materials[body.material]["use"], scene.where(f"materials.{body.material}")
    )
    size.add(cells, element, law)
    nodes = max(len(edge) - 1 for edge in element.edges)
    for edge_set, friction in slaves.get(name, ()):
        size.add_contact(nodes * edges(edge_set), friction)


def _sides(mesh: Mapping[str, Any], level: int) -> Callable[[str], float]:
    """Return edges on the whole boundary of a mesh with a given number of cells, for any edge set."""
    counts = mesh.get("cells")
    around = sum(_sum(count) for count in counts) if isinstance(counts, list | tuple) else 0.0
    return lambda edge_set: 2.0 * level * around


def _edges(body: Body) -> Callable[[str], float]:
    """Return edges in a set of an existing mesh."""
    return lambda edge_set: float(len(body.mesh.edges[edge_set])) if edge_set in body.mesh.edges else 0.0


def _cells(mesh: Mapping[str, Any], level: int) -> float:
    """Return cells of a mesh that gives their number, at a level; 0 for others."""
    counts = mesh.get("cells")
    if not isinstance(counts, list | tuple) or not counts:
        return 0.0
    return math.prod(_sum(count) * float(level) for count in counts)


def _sum(count: Any) -> float:
    if isinstance(count, list | tuple):
        return sum(_sum(part) for part in count)
    return float(count) if isinstance(count, int | float | np.integer) and not isinstance(count, bool) else 0.0
