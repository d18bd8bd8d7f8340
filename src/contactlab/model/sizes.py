"""How large a scene will be, before anything is allocated for it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.errors import SceneError
from contactlab.meshing.room import CELL_BYTES, in_gib, machine_memory

if TYPE_CHECKING:
    from contactlab.errors import Location
    from contactlab.scene.scene import Scene

SEGMENT_BYTES = 200.0  # of a rigid surface: positions, edges and what a contact keeps for each
FRAME_BYTES = 12.0  # that a frame keeps in memory until the run ends, per node: positions and a value to show
THREADS_PER_CORE = 4
FEWER = "fewer cells, a smaller level, or longer segments"


def check_sizes(scene: Scene) -> None:
    """Raise SceneError, with key, estimate and limit, for what cannot fit into this machine."""
    most = THREADS_PER_CORE * (os.cpu_count() or 1)
    if scene.threads > most:
        raise SceneError(
            "more threads than would ever help",
            where=scene.where("threads"),
            got=scene.threads,
            allowed=f"at most {most}: {THREADS_PER_CORE} for each core of this machine",
        )
    total = 0.0
    for name, body in scene.bodies.items():
        total += _cells(body.mesh, scene.level)
        _fits(CELL_BYTES * total, scene.where(f"bodies.{name}.mesh.cells"), _mesh_words(body.mesh, scene.level, total))


def estimated_bytes(scene: Scene) -> float:
    """Bytes that the model of a scene will take, by its cells; 0 where a mesh does not say how many it will have."""
    cells = [_cells(body.mesh, scene.level) for body in scene.bodies.values()]
    return CELL_BYTES * sum(cells) if all(cells) else 0.0


def check_frame_size(frames: int, nodes: int, where: Location) -> None:
    """Raise SceneError where the stored frames of a run are more than this machine can hold.

    frames  that will be stored at most: as many as the scene asks for, but no more than steps
    """
    _fits(FRAME_BYTES * frames * nodes, where, f"{frames} frames of {nodes} nodes", "fewer frames, or a coarser mesh")


def check_rigid_size(points: float, where: Location, segment: float) -> None:
    """Raise SceneError where a rigid surface has more segments than this machine can hold."""
    _fits(SEGMENT_BYTES * points, where, f"{points:.3g} segments of {segment:.3g} mm")


def _fits(
    size: float, where: Location, got: str, hint: str = "fewer cells, a smaller level, or longer segments"
) -> None:
    limit = machine_memory()
    if size > limit:
        raise SceneError(
            "this needs more memory than there is",
            where=where,
            got=f"{got}: about {in_gib(size)}",
            allowed=f"what fits into {in_gib(limit)}",
            hint=hint,
        )


def _mesh_words(mesh: Any, level: int, total: float) -> str:
    return f"{mesh.get('cells')} at level {level}, {total:.3g} cells so far"


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
