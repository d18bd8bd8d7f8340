"""Grids for authors of meshes: a lattice over the unit square, mapped to the body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.element import Element
from contactlab.api.mesh import Mesh

Map = Callable[[Floats, Floats], tuple[Floats, Floats]]
"""From coordinates in the unit square, each (N,), to positions [mm]."""


def lattice_order(element: Element) -> int:
    """Return lattice steps per cell side: 2 if the element has nodes between its corners."""
    return 1 if np.all(np.abs(element.nodes) == 1.0) else 2


def structured(element: Element, cells: tuple[int, int], place: Map) -> Mesh:
    """Return a grid of `cells` (columns, rows) over the unit square, mapped by `place`.

    Nodes between corners are mapped too, so that they lie on curved sides. Edge sets: bottom,
    right, top, left.
    """
    order = lattice_order(element)
    columns, rows = cells
    width = order * columns + 1
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    corner = order * (j.ravel() * width + i.ravel())
    offset = np.rint((element.nodes + 1.0) / 2.0 * order).astype(int)
    lattice = corner[:, None] + offset[:, 1] * width + offset[:, 0]
    used, numbered = np.unique(lattice, return_inverse=True)
    x, y = place((used % width) / (order * columns), (used // width) / (order * rows))
    grid = numbered.reshape(lattice.shape).astype(np.int32)
    return Mesh(np.stack([x, y], axis=1), grid, _sides(element, grid, columns, rows))


def _sides(element: Element, cells: Ints, columns: int, rows: int) -> dict[str, Ints]:
    grid = cells.reshape(rows, columns, -1)
    along = {"bottom": grid[0], "right": grid[:, -1], "top": grid[-1, ::-1], "left": grid[::-1, 0]}
    return {name: np.ascontiguousarray(strip[:, side_nodes(element, name)]) for name, strip in along.items()}


def side_nodes(element: Element, name: str) -> list[int]:
    """Return local nodes of the side at the bottom, right, top or left of the reference square."""
    axis, value = {"bottom": (1, -1.0), "right": (0, 1.0), "top": (1, 1.0), "left": (0, -1.0)}[name]
    for edge in element.edges:
        if np.all(element.nodes[list(edge), axis] == value):
            return list(edge)
    raise ValueError(f"{type(element).__name__} has no side on the {name} of its reference square")


def renamed(mesh: Mesh, names: Mapping[str, str]) -> Mesh:
    """Return the mesh with other names for its edge sets; sets without a new name are left out."""
    return replace(mesh, edges={new: mesh.edges[old] for old, new in names.items()})
