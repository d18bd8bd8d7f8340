"""Checks of mesh sources."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import ClassVar, Literal

import numpy as np
from scipy.spatial import cKDTree

from contactlab.api import Element, Floats, Mesh, MeshSource, Quadrature, Shape
from contactlab.meshing.mesh import inverted_cells, nodal_measure, surface_from_edges
from contactlab.testing.assertions import Check, agree, require
from contactlab.testing.units import LONG, in_other_units

_SIDES = ((0, 1), (1, 2), (2, 3), (3, 0))
SLIT = 0.05  # of the shortest side: nodes nearer than this were meant to be one
_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@dataclass(frozen=True)
class FourNodes(Element):
    """The bilinear quadrilateral, so that meshes can be checked without any element plugin."""

    nodes: ClassVar[Floats] = _CORNERS
    edges: ClassVar[tuple[tuple[int, ...], ...]] = _SIDES
    degree: ClassVar[int] = 1
    locks: ClassVar[bool] = True
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "row-sum"

    def shape(self, points: Floats) -> Shape:
        """(1 + xi_a xi)(1 + eta_a eta)/4."""
        xi, eta = 1.0 + points[:, :1] * _CORNERS[:, 0], 1.0 + points[:, 1:] * _CORNERS[:, 1]
        return Shape(0.25 * xi * eta, 0.25 * np.stack([_CORNERS[:, 0] * eta, _CORNERS[:, 1] * xi], axis=-1))

    def quadrature(self) -> Quadrature:
        """Rule of 2x2 Gauss points."""
        return Quadrature(_CORNERS / np.sqrt(3.0), np.ones(4))

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Values and derivatives (n, 2) of the two linear functions of an edge at s."""
        return np.stack([0.5 * (1.0 - s), 0.5 * (1.0 + s)], axis=1), np.tile([-0.5, 0.5], (len(s), 1))


def _sides_of(mesh: Mesh) -> set[tuple[int, int]]:
    """Start and end of every side of every cell, the cell on the left."""
    return {(int(cell[a]), int(cell[b])) for cell in mesh.cells for a, b in _SIDES}


def cells_are_sound(source: MeshSource) -> None:
    """Cells are counter-clockwise, use existing nodes, and leave none unused."""
    mesh = source.mesh(FourNodes(), 1)
    require(len(mesh.cells) > 0, "the mesh has no cells")
    require(mesh.cells.dtype == np.int32 and mesh.nodes.dtype == np.float64, "cells are int32, nodes float64")
    require(mesh.cells.min() >= 0 and mesh.cells.max() < len(mesh.nodes), "a cell names a node that does not exist")
    require(len(np.unique(mesh.cells)) == len(mesh.nodes), "a node belongs to no cell")
    folded = inverted_cells(mesh, FourNodes())
    require(not len(folded), f"cells {folded[:5].tolist()} are inverted")
    sides = np.array(sorted(_sides_of(mesh)))
    shortest = float(np.hypot(*(mesh.nodes[sides[:, 1]] - mesh.nodes[sides[:, 0]]).T).min())
    near = cKDTree(mesh.nodes).query_pairs(SLIT * shortest)
    place = str(mesh.nodes[min(near)[0]].round(4).tolist()) if near else ""
    require(not near, f"two nodes coincide, or nearly so, at {place}: the mesh has a slit")


def edges_are_the_boundary(source: MeshSource) -> None:
    """Edges of the sets are sides of cells with the body on the left, and no cell is beyond them."""
    mesh = source.mesh(FourNodes(), 2)
    require(len(mesh.edges) > 0, "the mesh has no edge set, so that supports and contact are impossible")
    sides = _sides_of(mesh)
    for name, edges in mesh.edges.items():
        for start, end in edges[:, :2].tolist():
            require((start, end) in sides, f"edge set {name}: {start} to {end} is not a side with its cell on the left")
            require((end, start) not in sides, f"edge set {name}: {start} to {end} lies between two cells")
        surface_from_edges(edges)


def level_multiplies_cells(source: MeshSource) -> None:
    """Level L has L^2 times as many cells and the same area, up to what curved sides gain."""
    meshes = [source.mesh(FourNodes(), level) for level in (1, 2, 4)]
    counts = [len(mesh.cells) for mesh in meshes]
    require(counts == [counts[0], 4 * counts[0], 16 * counts[0]], f"cells at levels 1, 2, 4: {counts}")
    areas = [float(nodal_measure(mesh, FourNodes()).sum()) for mesh in meshes]
    gains = [abs(areas[1] - areas[0]), abs(areas[2] - areas[1])]
    require(gains[1] <= 0.5 * gains[0] + 1e-12 * areas[0], f"areas at levels 1, 2, 4 do not settle: {areas}")


def same_mesh_twice(source: MeshSource) -> None:
    """The mesh depends on the fields and the level alone."""
    one, two = source.mesh(FourNodes(), 2), source.mesh(FourNodes(), 2)
    agree(two.nodes, one.nodes, 0.0, "nodes of a second call")
    agree(two.cells, one.cells, 0, "cells of a second call")


def the_boundary_is_named(source: MeshSource) -> None:
    """Every side at the boundary belongs to an edge set, so that it can be supported, loaded and touched."""
    mesh = source.mesh(FourNodes(), 1)
    sides = _sides_of(mesh)
    boundary = {(a, b) for a, b in sides if (b, a) not in sides}
    named = {(int(a), int(b)) for edges in mesh.edges.values() for a, b in edges[:, :2]}
    left = boundary - named
    where = mesh.nodes[min(left)[0]].round(4).tolist() if left else ""
    require(not left, f"{len(left)} of {len(boundary)} boundary sides belong to no edge set, for example at {where}")


def points_move_as_a_whole(source: MeshSource) -> None:
    """A field with x and y, as a point, has an effect by both entries or by neither: none is forgotten."""
    for field in fields(source):  # type: ignore[arg-type]
        value = getattr(source, field.name)
        if not (isinstance(value, tuple) and len(value) == 2 and all(isinstance(one, float) for one in value)):
            continue
        plain = source.mesh(FourNodes(), 1).nodes
        counts = []
        for k in range(2):
            moved = tuple(one + 0.25 * (j == k) * (1.0 + abs(one)) for j, one in enumerate(value))
            try:
                nodes = replace(source, **{field.name: moved}).mesh(FourNodes(), 1).nodes  # type: ignore[type-var]
            except ValueError:
                break  # out of the bounds that the part sets itself
            counts.append(not np.array_equal(nodes, plain))
        require(len(counts) < 2 or counts[0] == counts[1], f"only one of the two entries of {field.name} moves nodes")


def units_do_not_matter(source: MeshSource) -> None:
    """Nodes are at the same places with lengths in m instead of mm."""
    other = in_other_units(source)
    agree(
        other.mesh(FourNodes(), 1).nodes,
        LONG * source.mesh(FourNodes(), 1).nodes,
        1e-9 * LONG * float(np.abs(source.mesh(FourNodes(), 1).nodes).max()),
        "nodes in m: units of its fields are inconsistent, or it has a length of its own",
    )


CHECKS: tuple[Check, ...] = (
    cells_are_sound,
    edges_are_the_boundary,
    level_multiplies_cells,
    the_boundary_is_named,
    points_move_as_a_whole,
    same_mesh_twice,
    units_do_not_matter,
)
