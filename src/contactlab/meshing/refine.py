"""Any quadrilaterals cut finer and given the nodes of an element: how meshes from files take level and element."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Element, Floats, Ints, Mesh
from contactlab.api.meshing import lattice_order, side_nodes

Indices = NDArray[np.int64]
"""Numbers of a file's points and cells, which may be many."""

SIDES = ("bottom", "right", "top", "left")
"""Sides of a cell in the order in which its corners follow one another."""


class Quads(NamedTuple):
    """Nodes and cells of a mesh as they were read.

    points  (p, 2) [mm]
    cells   (n, 4, 8 or 9) corners counter-clockwise, mid-sides, middle
    sides   edge sets by name, each (e, 2): cell and number of its side
    """

    points: Floats
    cells: Indices
    sides: dict[str, Indices]


def refined(quads: Quads, element: Element, level: int) -> Mesh:
    """Every cell cut into level x level, with the nodes of `element`; curved cells stay curved."""
    order = lattice_order(element)
    steps = level * order
    numbers = _lattice_numbers(quads.cells[:, :4], steps)
    # lattice positions (level^2, a) of the nodes of every sub-cell, row by row
    i, j = np.meshgrid(np.arange(level), np.arange(level))
    corner = order * (j.ravel() * (steps + 1) + i.ravel())
    offset = np.rint((element.nodes + 1.0) / 2.0 * order).astype(int)
    grid = np.asarray(corner[:, None] + offset[:, 1] * (steps + 1) + offset[:, 0])
    cells = numbers[:, grid].reshape(-1, len(element.nodes))
    used, first = np.unique(cells, return_index=True)
    # positions (n, (steps + 1)^2, 2) of the lattice, by the cells' own shape functions
    t = np.linspace(-1.0, 1.0, steps + 1)
    xi, eta = (place.ravel() for place in np.meshgrid(t, t))
    lattice = np.asarray(np.einsum("sa,nai->nsi", shapes(quads.cells.shape[1], xi, eta), quads.points[quads.cells]))
    place = lattice[:, grid].reshape(-1, 2)[first]
    final = np.zeros(used[-1] + 1, np.int32)
    final[used] = np.arange(len(used))
    renumbered: Ints = final[cells]
    edges = {name: _edges(renumbered, side, element, level) for name, side in quads.sides.items()}
    return Mesh(np.ascontiguousarray(place), renumbered, edges)


def _lattice_numbers(corners: Indices, steps: int) -> Indices:
    """Numbers (n, (steps + 1)^2) of the lattice nodes of every cell, shared along common sides."""
    n, inner = len(corners), steps - 1
    pairs = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
    _, edge = np.unique(np.sort(pairs, axis=2).reshape(-1, 2), axis=0, return_inverse=True)
    edge = edge.reshape(n, 4)
    backwards = pairs[:, :, 0] > pairs[:, :, 1]
    numbers = np.zeros((n, steps + 1, steps + 1), np.int64)
    numbers[:, 0, 0], numbers[:, 0, -1], numbers[:, -1, -1], numbers[:, -1, 0] = corners.T
    start = int(corners.max()) + 1
    along = np.arange(inner)
    views = (numbers[:, 0, 1:-1], numbers[:, 1:-1, -1], numbers[:, -1, -2:0:-1], numbers[:, -2:0:-1, 0])
    for side, view in enumerate(views):
        view[:] = start + edge[:, side, None] * inner + np.where(backwards[:, side, None], inner - 1 - along, along)
    start += (int(edge.max()) + 1) * inner
    numbers[:, 1:-1, 1:-1] = start + np.arange(n * inner * inner).reshape(n, inner, inner)
    return numbers.reshape(n, -1)


def shapes(nodes: int, xi: Floats, eta: Floats) -> Floats:
    """Shape functions (s, nodes) of the 4-, 8- and 9-node quadrilateral at reference points."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    x, y = xi[:, None] * corners[:, 0], eta[:, None] * corners[:, 1]
    if nodes == 4:
        return np.asarray(0.25 * (1.0 + x) * (1.0 + y))
    if nodes == 8:
        sides = [(1.0 - xi**2) * (1.0 - eta), (1.0 + xi) * (1.0 - eta**2), (1.0 - xi**2) * (1.0 + eta),
                 (1.0 - xi) * (1.0 - eta**2)]  # fmt: skip
        return np.concatenate([0.25 * (1.0 + x) * (1.0 + y) * (x + y - 1.0), 0.5 * np.stack(sides, axis=1)], axis=1)
    a, b = ([0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0)] for s in (xi, eta))
    order = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))
    return np.stack([a[i] * b[j] for i, j in order], axis=1)


def _edges(cells: Ints, sides: Indices, element: Element, level: int) -> Ints:
    """Edges (e level, b) of one edge set, in the order of its sides."""
    grid = cells.reshape(-1, level, level, cells.shape[1])
    chosen = {
        "bottom": grid[:, 0, :], "right": grid[:, :, -1], "top": grid[:, -1, ::-1], "left": grid[:, ::-1, 0],
    }  # fmt: skip
    width = len(element.edges[0])
    out = np.empty((len(sides), level, width), np.int32)
    for number, name in enumerate(SIDES):
        own = sides[:, 1] == number
        out[own] = chosen[name][sides[own, 0]][:, :, side_nodes(element, name)]
    return out.reshape(-1, width)
