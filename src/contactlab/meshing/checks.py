"""Checks of every body's mesh, whatever its source, before anything is computed from it."""

from __future__ import annotations

import numpy as np

from contactlab.api import Element, Ints, Mesh
from contactlab.errors import SceneError, Where
from contactlab.meshing.mesh import inverted_cells, jacobians

FARTHEST = 1e100  # coordinates beyond it overflow when they are squared twice
NO_AREA = 1e-12  # determinant of a cell over the square of its size: round-off


def check_mesh(mesh: Mesh, element: Element, where: Where) -> None:
    """Raise SceneError for nodes that are nowhere, cells without area, folded or there twice, and loose pieces."""
    if not len(mesh.cells):
        raise SceneError("the mesh has no cells", where=where, got="0 cells", allowed="at least one")
    _check_places(mesh, where)
    _check_twice(mesh, where)
    _check_areas(mesh, element, where)
    _check_pieces(mesh, where)


def _check_places(mesh: Mesh, where: Where) -> None:
    lost = np.flatnonzero(~(np.abs(mesh.nodes) <= FARTHEST).all(axis=1))
    if len(lost):
        x, y = mesh.nodes[lost[0]]
        raise SceneError(
            f"{len(lost)} of {len(mesh.nodes)} nodes have no valid position",
            where=where,
            got=f"node {lost[0]} at ({x:g}, {y:g})",
            allowed=f"finite coordinates up to {FARTHEST:g}",
            hint="check the coordinates of the mesh, and shift",
        )


def _check_twice(mesh: Mesh, where: Where) -> None:
    nodes = np.sort(mesh.cells, axis=1)
    order = np.lexsort(nodes.T)  # stable: of equal cells the first comes first
    again = np.flatnonzero((nodes[order[1:]] == nodes[order[:-1]]).all(axis=1))
    if len(again):
        copies, first = order[again + 1], order[again]
        raise SceneError(
            f"{len(again)} of {len(mesh.cells)} cells are duplicates, which doubles stiffness and mass",
            where=where,
            got=f"cell {copies.min()} has the nodes of cell {first[copies.argmin()]}",
            allowed="every cell once",
            hint="remove the duplicates from the mesh",
        )


def _check_areas(mesh: Mesh, element: Element, where: Where) -> None:
    # determinants (n, q) at the quadrature points over the square of each cell's largest extent
    extent = np.ptp(mesh.nodes[mesh.cells], axis=1).max(axis=1)
    areas = np.asarray(jacobians(mesh, element, element.quadrature().points) / np.maximum(extent, 1e-150)[:, None] ** 2)
    empty = np.flatnonzero(np.abs(areas).max(axis=1) <= NO_AREA)
    _refuse_cells(
        mesh, empty, where, "have no area", "cells whose corners do not lie on one line or in one place",
        "check for coincident nodes",
    )  # fmt: skip
    _refuse_cells(
        mesh, inverted_cells(mesh, element), where, "are inverted",
        "cells numbered counter-clockwise with positive area at every node and point",
        "check the order of the nodes and the numbers of the mesh",
    )  # fmt: skip


def _refuse_cells(mesh: Mesh, found: np.ndarray, where: Where, what: str, allowed: str, hint: str) -> None:
    """Raise SceneError if cells were found, with the first of them."""
    if len(found):
        raise SceneError(
            f"{len(found)} of {len(mesh.cells)} cells {what}",
            where=where,
            got=f"cell {found[0]} first, nodes {mesh.cells[found[0]].tolist()}",
            allowed=allowed,
            hint=hint,
        )


def _check_pieces(mesh: Mesh, where: Where) -> None:
    label = pieces(mesh.cells, len(mesh.nodes))
    found = np.unique(label[mesh.cells[:, 0]])
    if len(found) > 1:
        cells = np.flatnonzero(label[mesh.cells[:, 0]] == found[1])
        raise SceneError(
            f"the mesh has {len(found)} pieces that share no node",
            where=where,
            got=f"cells {len(mesh.cells) - len(cells)} and {len(cells)}, cell {cells[0]} the first of the latter",
            allowed="one piece per body",
            hint="make each piece a separate body, or merge coincident nodes",
        )


def pieces(cells: Ints, nodes: int) -> Ints:
    """Label (nodes,) of the piece that each node belongs to, by `cells` (n, a) that join nodes: its lowest node.

    Union of sets: cells hook the labels of their nodes onto the lowest of them until no cell has two. SciPy's graph
    routines would do the same, but their import costs each start more than this does on a mesh of 50 000 cells.
    """
    label = np.arange(nodes, dtype=cells.dtype)
    while len(cells):
        found = label[cells]
        lowest = found.min(axis=1)
        apart = (found != lowest[:, None]).any(axis=1)
        cells = cells[apart]
        parent = np.arange(nodes, dtype=cells.dtype)
        np.minimum.at(parent, found[apart].ravel(), lowest[apart].repeat(cells.shape[1]))
        while (parent[parent] != parent).any():
            parent = parent[parent]
        label = parent[label]
    return label
