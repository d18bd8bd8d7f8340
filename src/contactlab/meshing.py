"""Structured meshes from a few numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactlab.api import Element, Floats, Ints, Mesh, MeshSource

Map = Callable[[Floats, Floats], tuple[Floats, Floats]]


def structured(element: Element, cells: tuple[int, int], place: Map) -> Mesh:
    """A grid of `cells` (columns, rows) over the unit square, mapped by `place`.

    Nodes between corners are mapped too, so that they lie on curved sides. Edge sets: bottom,
    right, top, left.
    """
    order = 1 if np.all(np.abs(element.nodes) == 1.0) else 2
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
    return {name: np.ascontiguousarray(strip[:, _side_nodes(element, name)]) for name, strip in along.items()}


def _side_nodes(element: Element, name: str) -> list[int]:
    axis, value = {"bottom": (1, -1.0), "right": (0, 1.0), "top": (1, 1.0), "left": (0, -1.0)}[name]
    for edge in element.edges:
        if np.all(element.nodes[list(edge), axis] == value):
            return list(edge)
    raise ValueError(f"{type(element).__name__} has no side on the {name} of its reference square")


def _check_cells(cells: tuple[int, int]) -> None:
    if len(cells) != 2 or min(cells) < 1:
        raise ValueError(f"cells: got {list(cells)}, allowed: two counts of at least 1, [columns, rows]")


def _check_span(name: str, span: tuple[float, float]) -> None:
    if len(span) != 2 or not span[0] < span[1]:
        raise ValueError(f"{name}: got {list(span)}, allowed: two increasing coordinates [mm]")


@dataclass(frozen=True)
class Rectangle(MeshSource):
    """A rectangle of equal cells; edge sets bottom, right, top, left.

    x, y   the two corner coordinates in each direction [mm]
    cells  columns and rows at level 1
    """

    x: tuple[float, float]
    y: tuple[float, float]
    cells: tuple[int, int]

    def __post_init__(self) -> None:
        _check_span("x", self.x)
        _check_span("y", self.y)
        _check_cells(self.cells)

    def mesh(self, element: Element, level: int) -> Mesh:
        """Equal cells, counts times `level`."""
        (x0, x1), (y0, y1) = self.x, self.y
        counts = (self.cells[0] * level, self.cells[1] * level)
        return structured(element, counts, lambda s, t: (x0 + s * (x1 - x0), y0 + t * (y1 - y0)))


@dataclass(frozen=True)
class ArcBlock(MeshSource):
    """The region between the arc y = radius - sqrt(radius^2 - x^2), |x| <= half_width, and the flat y = top.

    Node columns are uniform in x, nodes linear in y within a column; the lowest point of the arc is
    the origin. Edge sets arc, right, top, left.

    radius      of the arc [mm]
    half_width  [mm], at most the radius
    top         height of the flat top above the lowest point [mm]
    cells       columns and rows at level 1
    """

    radius: float
    half_width: float
    top: float
    cells: tuple[int, int]

    def __post_init__(self) -> None:
        _check_cells(self.cells)
        if not 0.0 < self.half_width <= self.radius:
            raise ValueError(f"half_width: got {self.half_width}, allowed: 0 < half_width <= radius = {self.radius}")
        if not self.top > self._arc(self.half_width):
            raise ValueError(f"top: got {self.top}, allowed: above the end of the arc, {self._arc(self.half_width):g}")

    def _arc(self, x: Floats | float) -> Floats:
        return np.asarray(self.radius - np.sqrt(self.radius**2 - np.asarray(x) ** 2))

    def mesh(self, element: Element, level: int) -> Mesh:
        """Counts times `level`; nodes on the lower side lie on the true arc."""

        def place(s: Floats, t: Floats) -> tuple[Floats, Floats]:
            x = self.half_width * (2.0 * s - 1.0)
            low = self._arc(x)
            return x, low + t * (self.top - low)

        mesh = structured(element, (self.cells[0] * level, self.cells[1] * level), place)
        return Mesh(mesh.nodes, mesh.cells, {"arc" if k == "bottom" else k: v for k, v in mesh.edges.items()})
