"""How large a scene will be, before anything is allocated for it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.errors import SceneError

if TYPE_CHECKING:
    from contactlab.errors import Location
    from contactlab.scene.scene import Scene

CELL_BYTES = 600.0  # of a model, per linear cell: 741 MiB were measured for a million, libraries included
SEGMENT_BYTES = 200.0  # of a rigid surface: positions, edges and what a contact keeps for each
THREADS_PER_CORE = 4


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


def check_rigid_size(points: float, where: Location, segment: float) -> None:
    """Raise SceneError where a rigid surface has more segments than this machine can hold."""
    _fits(SEGMENT_BYTES * points, where, f"{points:.3g} segments of {segment:.3g} mm")


def _fits(size: float, where: Location, got: str) -> None:
    limit = machine_memory()
    if size > limit:
        raise SceneError(
            "this needs more memory than there is",
            where=where,
            got=f"{got}: about {_in_words(size)}",
            allowed=f"what fits into {_in_words(limit)}",
            hint="fewer cells, a smaller level, or longer segments",
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


def machine_memory() -> float:
    """Bytes of memory that this process may use: of the machine, or of the group that it runs in."""
    try:
        total = float(os.sysconf("SC_PHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf
    for name in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            total = min(total, float(Path(name).read_text()))
        except (OSError, ValueError):
            continue  # no such group, or no limit ("max")
    return total


def _in_words(size: float) -> str:
    return f"{size / 2.0**30:.3g} GiB"
