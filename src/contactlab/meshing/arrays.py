"""Meshes from arrays, PyVista grids and gmsh models: kept in the scene itself, so that no file is needed."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from numbers import Real
from os import PathLike
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contactlab.api import Element, Mesh, MeshSource
from contactlab.arguments import arguments
from contactlab.errors import RequestError, did_you_mean
from contactlab.meshing.file import EVERYTHING, quads_of
from contactlab.meshing.refine import refined
from contactlab.meshing.room import check_number

CELLS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
"""Names of cells in meshio, by number of nodes."""
VTK = {5: 3, 9: 4, 22: 6, 23: 8, 28: 9}
GMSH = {2: 3, 3: 4, 9: 6, 10: 9, 16: 8}
"""Nodes of a plane cell by the number of its type."""
GMSH_LINES = (1, 8)

EdgeSet = ArrayLike | Callable[[Any], ArrayLike]


@dataclass(frozen=True)
class MeshArrays(MeshSource):
    """A mesh of quadrilaterals that the scene holds itself, as `contactlab.mesh` writes it.

    Edge sets are those that were named, and `boundary`. Each cell is cut into level x level.

    content  the arrays, compressed
    """

    content: str

    def __post_init__(self) -> None:
        try:
            data = json.loads(zlib.decompress(base64.b64decode(self.content, validate=True)))
            object.__setattr__(self, "_file", _as_file(data))
        except (ValueError, KeyError, TypeError, AttributeError, zlib.error) as error:
            raise ValueError("content: got no arrays of a mesh, allowed: what contactlab.mesh writes") from error

    def mesh(self, element: Element, level: int) -> Mesh:
        """The cells with the nodes of `element`; ValueError says what is wrong with them."""
        quads = quads_of(self._file, "", 1.0)  # type: ignore[attr-defined]
        check_number(f"cells: got {len(quads.cells)}", len(quads.cells), level)
        return refined(quads, element, level)


class MeshSpec(dict[str, Any]):
    """A mesh as a scene takes it: `scene.with_({"bodies.block.mesh": mesh})`."""

    def __repr__(self) -> str:
        file = MeshArrays(self["content"])._file  # type: ignore[attr-defined]
        sets = ", ".join([EVERYTHING, *file.names])
        return f"mesh of {sum(len(block.data) for block in file.cells[:1])} cells, edge sets {sets}"


@dataclass
class _Parts:
    """Parts of a mesh: nodes, cells, and edge sets as lines (k, 2) or as nodes (k,)."""

    points: np.ndarray
    cells: np.ndarray
    sets: dict[str, np.ndarray] = field(default_factory=dict)


@arguments(sets=Mapping, scale=Real)
def mesh(points: Any, cells: Any = None, sets: Mapping[str, EdgeSet] | None = None, scale: float = 1.0) -> MeshSpec:
    """Make a mesh for a body of a scene: `scene.with_({"bodies.clip.mesh": contactlab.mesh(points, cells, sets)})`.

    points  nodes (N, 2); or a PyVista grid; or a gmsh model (`gmsh.model` or `gmsh`), meshed
    cells   (n, 4), (n, 8) or (n, 9) node numbers from 0, in either direction; of a gmsh model the name of the physical
            surface to take; not needed for a grid
    sets    edge sets by name: edges (k, 2), or nodes that they lie between: numbers (k,), a mask (N,), or a function
            of the positions (N, 2) that gives one. A gmsh model has its physical curves as well
    scale   factor on all coordinates

    The mesh is stored in the scene: results and comparisons need no file. Raises RequestError.
    """
    try:
        parts = _parts(points, cells)
        parts.sets |= {name: _edges(value, parts.points) for name, value in (sets or {}).items()}
        parts.points = parts.points * scale
        if parts.cells.ndim != 2 or parts.cells.shape[1] not in CELLS:
            raise ValueError(f"cells of shape {parts.cells.shape}, allowed: (n, 4), (n, 8) or (n, 9)")
        if not np.isfinite(parts.points).all():
            raise ValueError("coordinates that are not finite")
        edges = {name: value.tolist() for name, value in parts.sets.items()}
        data = {"points": parts.points.tolist(), "cells": parts.cells.tolist(), "sets": edges}
        found = quads_of(_as_file(data), "", 1.0).sides
        for name in sets or {}:
            if name not in found:
                raise ValueError(f'edge set "{name}" holds no side of a cell on the outline')
        packed = zlib.compress(json.dumps(data, separators=(",", ":"), allow_nan=False).encode(), 9)
        spec = MeshSpec({"use": "arrays", "content": base64.b64encode(packed).decode()})
    except (ValueError, TypeError, OverflowError, IndexError) as error:
        raise RequestError(
            f"invalid mesh: {str(error).removeprefix('path: ')}", where="contactlab.mesh", got=[points, cells, sets],
            allowed="points (N, 2), cells (n, 4), (n, 8) or (n, 9), edge sets (k, 2) or (k,), which are numbers",
        ) from error  # fmt: skip
    return spec


def _parts(points: Any, cells: Any) -> _Parts:
    if isinstance(points, str | PathLike):
        raise RequestError(
            "a mesh from a file needs no call", where="contactlab.mesh", got=str(points),
            allowed="arrays, a PyVista grid or a gmsh model",
            hint=f'name it in the scene: mesh = {{ use = "file", path = "{points}" }}',
        )  # fmt: skip
    if hasattr(getattr(points, "model", None), "getPhysicalGroups"):
        points = points.model  # of the module gmsh
    if hasattr(points, "getPhysicalGroups") and hasattr(points, "mesh"):
        return _of_gmsh(points, "" if cells is None else str(cells))
    if hasattr(points, "celltypes") and hasattr(points, "cells_dict"):
        found = {VTK[kind]: nodes for kind, nodes in points.cells_dict.items() if int(kind) in VTK}
        if len(found) != 1:
            kinds = ", ".join(CELLS[count] for count in found) or "no plane cells"
            raise ValueError(f"the grid has {kinds}, allowed: cells of one kind")
        return _Parts(np.asarray(points.points, float), np.asarray(next(iter(found.values())), np.int64))
    if cells is None:
        raise RequestError("cells are needed with points", where="contactlab.mesh", allowed="node numbers (n, 4)")
    return _Parts(np.asarray(points, float), np.asarray(cells, np.int64))


def _of_gmsh(model: Any, group: str) -> _Parts:
    """Nodes, the cells of one physical surface (or of all surfaces), and all physical curves."""
    tags, coordinates, _ = model.mesh.getNodes()
    place = np.zeros(int(max(tags, default=0)) + 1, np.int64)
    place[tags] = np.arange(len(tags))
    surfaces, curves = _groups(model, 2), _groups(model, 1)
    if group and group not in surfaces:
        raise RequestError(
            "no such physical surface", where="contactlab.mesh", got=group, allowed=", ".join(surfaces),
            hint=did_you_mean(group, surfaces),
        )  # fmt: skip
    taken = surfaces[group] if group else [tag for _, tag in model.getEntities(2)]
    blocks: dict[int, list[np.ndarray]] = {}
    for tag in taken:
        for kind, nodes in _elements(model, 2, tag).items():
            blocks.setdefault(GMSH.get(kind, 0), []).append(place[nodes])
    if len(blocks) != 1 or 0 in blocks:
        kinds = ", ".join(CELLS.get(count, "others") for count in blocks) or "no cells (gmsh.model.mesh.generate(2))"
        raise ValueError(f"the model has {kinds}, allowed: cells of one kind (Mesh.RecombineAll makes quadrilaterals)")
    sets = {}
    for name, entities in curves.items():
        lines = [nodes[:, :2] for tag in entities for kind, nodes in _elements(model, 1, tag).items()
                 if kind in GMSH_LINES]  # fmt: skip
        if lines:
            sets[name] = place[np.concatenate(lines)]
    cells = np.concatenate(next(iter(blocks.values())))
    return _compact(_Parts(np.asarray(coordinates, float).reshape(-1, 3), cells, sets))


def _groups(model: Any, dimension: int) -> dict[str, list[int]]:
    """Entities of each physical group by its name."""
    groups = ((model.getPhysicalName(dim, tag) or f"tag-{tag}", dim, tag) for dim, tag in
              model.getPhysicalGroups(dimension))  # fmt: skip
    return {name: list(model.getEntitiesForPhysicalGroup(dim, tag)) for name, dim, tag in groups}


def _elements(model: Any, dimension: int, entity: int) -> dict[int, np.ndarray]:
    kinds, numbers, nodes = model.mesh.getElements(dimension, entity)
    return {
        int(kind): np.asarray(own, np.int64).reshape(len(count), -1)
        for kind, count, own in zip(kinds, numbers, nodes, strict=True)
    }


def _compact(parts: _Parts) -> _Parts:
    """Only the nodes of cells, and lines between them."""
    used = np.unique(parts.cells)
    place = np.full(len(parts.points), -1, np.int64)
    place[used] = np.arange(len(used))
    sets = {name: place[lines][(place[lines] >= 0).all(axis=1)] for name, lines in parts.sets.items()}
    kept = {name: lines for name, lines in sets.items() if len(lines)}
    return _Parts(parts.points[used], place[parts.cells], kept)


def _edges(value: EdgeSet, points: np.ndarray) -> np.ndarray:
    """Edges (k, 2) or nodes (k,)."""
    found = np.asarray(value(points[:, :2]) if callable(value) else value)
    if found.dtype == bool:
        if found.shape != (len(points),):
            raise ValueError(f"a mask of shape {found.shape}, allowed: ({len(points)},)")
        return np.flatnonzero(found)
    if found.ndim == 2 and found.shape[1] >= 2:
        found = found[:, :2]
    elif found.ndim != 1:
        raise ValueError(f"an edge set of shape {found.shape}, allowed: edges (k, 2) or nodes (k,)")
    found = found.astype(np.int64)
    if len(found) and not (found.min() >= 0 and found.max() < len(points)):
        raise ValueError(f"an edge set names node {found.max()}, there are {len(points)}, counted from 0")
    return found


def _as_file(data: Mapping[str, Any]) -> Any:
    """The arrays as meshio has the content of a file."""
    cells = np.asarray(data["cells"], np.int64)
    sets = {name: np.asarray(value, np.int64) for name, value in data["sets"].items()}
    lines = {name: value for name, value in sets.items() if value.ndim == 2}
    blocks = [SimpleNamespace(type=CELLS[cells.shape[1]], data=cells)]
    blocks += [SimpleNamespace(type="line", data=value) for value in lines.values()]
    members = {
        name: [np.arange(len(block.data) if block is own else 0) for block in blocks]
        for name, own in zip(lines, blocks[1:], strict=True)
    }
    points = {name: value for name, value in sets.items() if value.ndim == 1}
    return SimpleNamespace(
        points=np.asarray(data["points"], float), cells=blocks, cell_sets=members, point_sets=points, cell_data={},
        field_data={}, names=list(sets),
    )  # fmt: skip
