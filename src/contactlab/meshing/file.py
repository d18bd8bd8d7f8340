"""Meshes from files that meshio reads, with their named edge sets."""

from __future__ import annotations

import contextlib
import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api import Element, Floats, Mesh, MeshSource
from contactlab.meshing.refine import Indices, Quads, refined
from contactlab.meshing.room import check_file_size, check_number
from contactlab.outside_files import GROWTH, bounded_memory

CELLS = {"quad": 4, "quad8": 8, "quad9": 9}
LINES = ("line", "line3")
EVERYTHING = "boundary"
"""Name of the edge set of all sides that belong to one cell only."""

REVERSED = {4: [0, 3, 2, 1], 8: [0, 3, 2, 1, 7, 6, 5, 4], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}


@dataclass(frozen=True)
class MeshFile(MeshSource):
    """A mesh of quadrilaterals from a file (Gmsh, Abaqus, MED, VTK, ... : whatever meshio reads).

    Edge sets are the file's named groups of lines (Gmsh physical curves, cell sets), its named groups of
    points where they hold sides of cells, and `boundary`. Each cell is cut into level x level.

    path   the file; relative to the folder of the scene
    cells  name of the group of cells to take; not written: all
    scale  factor on all coordinates [mm per unit of the file]
    """

    path: Path
    cells: str = ""
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.scale < math.inf:
            raise ValueError(f"scale: got {self.scale}, allowed: a factor > 0")
        if not self.path.is_file():
            raise ValueError(
                f"path: got {self.path}, allowed: an existing mesh file, relative to the folder of the scene"
            )

    def mesh(self, element: Element, level: int) -> Mesh:
        """The file's cells with the nodes of `element`; ValueError says what keeps it from being a plane quad mesh."""
        check_file_size(self.path)
        quads = quads_of(_read(self.path), self.cells, self.scale)
        check_number(f"path: got {len(quads.cells)} cells", len(quads.cells), level)
        return refined(quads, element, level)


def _read(path: Path) -> Any:
    """Read the file by meshio, which ends the process on unknown formats: that is caught."""
    try:
        import meshio
    except ModuleNotFoundError as missing:
        raise ValueError("reading mesh files needs the library meshio, which is not installed") from missing
    words = io.StringIO()
    try:
        size = path.stat().st_size
        with contextlib.redirect_stdout(words), contextlib.redirect_stderr(words), bounded_memory(size):
            return meshio.read(path)
    except MemoryError as error:
        raise ValueError(
            f"path: got {path.name}, {size} bytes that need more than {GROWTH:g} times as much memory to read, "
            "allowed: a mesh file with less compression"
        ) from error
    except (Exception, SystemExit) as error:
        said = " ".join(f"{words.getvalue()} {error if not isinstance(error, SystemExit) else ''}".split())
        raise ValueError(
            f"path: got {path.name}, which meshio cannot read ({said or type(error).__name__}), "
            "allowed: a mesh in one of its formats, such as Gmsh 2.2 and 4.1, Abaqus, MED or VTK"
        ) from error


def quads_of(file: Any, group: str, scale: float) -> Quads:
    """The cells and edge sets in what meshio made of a file; ValueError says what is wrong with them."""
    points = _plane(np.asarray(file.points, np.float64)) * scale
    cells = _counter_clockwise(points, _inside(_chosen_cells(file, group), len(points)))
    sides = _Sides(cells)
    sets = {EVERYTHING: sides.boundary()}
    for name, lines in _named_lines(file).items():
        found = sides.matching(lines)
        if len(found):
            sets[name] = found
    for name, members in (file.point_sets or {}).items():
        found = sides.within(np.asarray(members))
        if len(found) and name not in sets:
            sets[name] = found
    return Quads(points, cells, sets)


def _plane(points: Floats) -> Floats:
    """Take x and y; raises ValueError if z varies or there are no nodes."""
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not len(points):
        raise ValueError(f"path: got coordinates of shape {list(points.shape)}, allowed: two or three for each node")
    if points.shape[1] > 2 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points[:, :2], axis=0).max():
        low, high = points[:, 2].min(), points[:, 2].max()
        raise ValueError(f"path: got a mesh that is not plane, z from {low:g} to {high:g}, allowed: a mesh in x and y")
    return np.ascontiguousarray(points[:, :2])


def _chosen_cells(file: Any, group: str) -> Indices:
    """Nodes of the quadrilaterals of a group, or of all."""
    kinds = {block.type for block in file.cells}
    found = sorted(kinds & set(CELLS))
    if len(found) != 1 or kinds & {"triangle", "triangle6", "triangle7"}:
        raise ValueError(
            f"path: got cells of type {', '.join(sorted(kinds)) or 'none'}, allowed: one of {', '.join(CELLS)} "
            "(in Gmsh: recombine the surface)"
        )
    groups = _groups(file, found[0])
    if group and group not in groups:
        raise ValueError(f"cells: got {group}, allowed: {', '.join(groups) or 'the file names no group of cells'}")
    blocks = [(i, block.data) for i, block in enumerate(file.cells) if block.type == found[0]]
    return np.concatenate([nodes[groups[group][i]] if group else nodes for i, nodes in blocks]).astype(np.int64)


def _inside(cells: Indices, nodes: int) -> Indices:
    """The cells; ValueError if they name a node twice, or one that does not exist: negative ones count from the end."""
    lost = np.argwhere((cells < 0) | (cells >= nodes))
    if len(lost):
        cell, place = lost[0]
        raise ValueError(
            f"path: got node {cells[cell, place]} in cell {cell}, allowed: the {nodes} nodes, counted from 0"
        )
    named = np.sort(cells, axis=1)
    twice = np.argwhere(named[:, 1:] == named[:, :-1])
    if len(twice):
        cell, place = twice[0]
        raise ValueError(f"path: got node {named[cell, place]} twice in cell {cell}, allowed: each node of a cell once")
    return cells


def _groups(file: Any, *types: str) -> dict[str, list[Indices]]:
    """Named groups of cells of these types: for each block of the file the numbers in it."""
    none = [np.zeros(0, np.int64)] * len(file.cells)
    found: dict[str, list[Indices]] = {}
    for name, members in (file.cell_sets or {}).items():
        own = [np.asarray(m if m is not None else [], np.int64) for m in members]
        own = [m if block.type in types else none[0] for m, block in zip(own, file.cells, strict=True)]
        if any(map(len, own)) and not name.startswith("gmsh:"):
            found[name] = own
    tags = (file.cell_data or {}).get("gmsh:physical")
    if tags is None:
        return found
    for i, (block, tag) in enumerate(zip(file.cells, tags, strict=True)):
        for value in np.unique(tag) if block.type in types else ():
            name = _physical_name(file, int(value), 1 if block.type in LINES else 2)
            if name not in found or not len(found[name][i]):
                found.setdefault(name, list(none))[i] = np.flatnonzero(tag == value)
    return found


def _physical_name(file: Any, tag: int, dimension: int) -> str:
    for name, (number, of) in (file.field_data or {}).items():
        if int(number) == tag and int(of) == dimension:
            return str(name)
    return f"tag-{tag}"


def _named_lines(file: Any) -> dict[str, Indices]:
    """End nodes (e, 2) of the lines of every named group."""
    out = {}
    for name, members in _groups(file, *LINES).items():
        parts = [block.data[own][:, :2] for block, own in zip(file.cells, members, strict=True) if len(own)]
        out[name] = np.concatenate(parts).astype(np.int64)
    return out


def _counter_clockwise(points: Floats, cells: Indices) -> Indices:
    """Cells numbered clockwise are turned around: which way is up is the file's own business."""
    x = points[cells[:, :4]]
    diagonals = x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]
    clockwise = diagonals[0][:, 0] * diagonals[1][:, 1] - diagonals[0][:, 1] * diagonals[1][:, 0] < 0.0
    turned = cells.copy()
    turned[clockwise] = cells[clockwise][:, REVERSED[cells.shape[1]]]
    return turned


class _Sides:
    """Sides of cells by their end nodes."""

    def __init__(self, cells: Indices) -> None:
        corners = cells[:, :4]
        pairs = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
        keys = np.sort(pairs, axis=1)
        _, number, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
        self.ends = pairs
        self.outer = count[number.ravel()] == 1
        self.place = {(int(a), int(b)): k for k, (a, b) in enumerate(keys) if self.outer[k]}

    @staticmethod
    def _named(sides: Indices) -> Indices:
        return np.stack([sides // 4, sides % 4], axis=1)

    def boundary(self) -> Indices:
        """All sides of one cell only, (e, 2): cell and side."""
        return self._named(np.flatnonzero(self.outer))

    def matching(self, lines: Indices) -> Indices:
        """Outer sides with these end nodes; lines inside the body, or of other bodies, are left out."""
        keys = ((int(min(line)), int(max(line))) for line in lines)
        return self._named(np.array([self.place[key] for key in keys if key in self.place], np.int64))

    def within(self, members: Indices) -> Indices:
        """Outer sides both of whose ends are among the nodes `members`."""
        held = np.isin(self.ends, members).all(axis=1)
        return self._named(np.flatnonzero(held & self.outer))
