"""Round bodies: a disc of five grids, and a ring or a part of one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from contactlab.api import Element, Floats, Ints, Mesh, MeshSource
from contactlab.api.meshing import Map, renamed, structured
from contactlab.meshing.blocks import arc_point
from contactlab.meshing.grading import axis, check_counts, check_ratios
from contactlab.meshing.room import check_number

SAME = 1e-9  # of the mesh's extent: nodes of two grids nearer than this are one
CORE = 0.5  # half the diagonal of the inner grid over the radius
BULGE = 0.06  # rise of the inner grid's sides over the radius: between a square and a circle

QUARTERS = ("right", "top", "left", "bottom")


@dataclass(frozen=True)
class Disc(MeshSource):
    """A full disc about the origin; edge sets arc (all around) and its quarters right, top, left, bottom.

    An inner grid with bulging sides, and a grid between each of its sides and a quarter of the circle.

    radius   [mm]
    cells    along each quarter, and from the inner grid to the circle, at level 1
    grading  from the inner grid to the circle, last over first cell size [-]
    """

    radius: float
    cells: tuple[int, int]
    grading: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.radius < math.inf:
            raise ValueError(f"radius: got {self.radius}, allowed: a radius > 0 [mm]")
        for count in self.cells:
            check_counts(count, 1, f"cells: got {list(self.cells)}")
        check_ratios(self.grading, 1, f"grading: got {self.grading}")

    def mesh(self, element: Element, level: int) -> Mesh:
        """Counts times `level`; nodes on the circle lie on it."""
        around, out = self.cells
        check_number(f"cells: got {list(self.cells)}", around * (around + 4.0 * out), level)
        around, out = around * level, out * level
        core = renamed(structured(element, (around, around), self._core), {})
        quarters = []
        for number, name in enumerate(QUARTERS):
            grid = structured(element, (out, around), self._quarter(number, level))
            quarters.append(renamed(grid, {"right": name}))
        mesh = welded([core, *quarters])
        whole = np.concatenate([mesh.edges[name] for name in QUARTERS])
        return Mesh(mesh.nodes, mesh.cells, {"arc": whole, **mesh.edges})

    def _corner(self, number: int) -> Floats:
        """Corner of the inner grid at -45 degrees and every 90 degrees from there."""
        angle = 0.5 * math.pi * number - 0.25 * math.pi
        return CORE * self.radius * np.array([math.cos(angle), math.sin(angle)])

    def _inner_side(self, number: int, t: Floats) -> Floats:
        return arc_point(self._corner(number), self._corner(number + 1), BULGE * self.radius, t[:, None])

    def _core(self, s: Floats, t: Floats) -> tuple[Floats, Floats]:
        """Fill the core by transfinite interpolation between its four sides."""
        right, left = self._inner_side(0, t), self._inner_side(2, 1.0 - t)
        top, bottom = self._inner_side(1, 1.0 - s), self._inner_side(3, s)
        s, t = s[:, None], t[:, None]
        a, b, c, d = self._corner(3), self._corner(0), self._corner(1), self._corner(2)
        corners = (1.0 - t) * ((1.0 - s) * a + s * b) + t * ((1.0 - s) * d + s * c)
        x = (1.0 - t) * bottom + t * top + (1.0 - s) * left + s * right - corners
        return x[:, 0], x[:, 1]

    def _quarter(self, number: int, level: int) -> Map:
        rows = axis((0.0, 1.0), self.cells[1], self.grading, level)

        def place(s: Floats, t: Floats) -> tuple[Floats, Floats]:
            angle = 0.5 * math.pi * (number + t) - 0.25 * math.pi
            outer = self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            inner, share = self._inner_side(number, t), rows(s)[:, None]
            x = inner + share * (outer - inner)
            return x[:, 0], x[:, 1]

        return place


@dataclass(frozen=True)
class Ring(MeshSource):
    """A ring about the origin, or the part of it between two angles.

    Edge sets inner and outer, and on a part of a ring start and end.

    radii    inner and outer [mm]
    cells    around and through the thickness, at level 1
    angles   where it begins and ends [degree], counter-clockwise from the x axis; 360 apart is a full ring
    grading  from inside to outside, last over first cell size [-]
    """

    radii: tuple[float, float]
    cells: tuple[int, int]
    angles: tuple[float, float] = (0.0, 360.0)
    grading: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.radii[0] < self.radii[1] < math.inf:
            raise ValueError(f"radii: got {list(self.radii)}, allowed: 0 < inner < outer [mm]")
        if not 0.0 < self.angles[1] - self.angles[0] <= 360.0:
            raise ValueError(
                f"angles: got {list(self.angles)}, allowed: two increasing angles, at most 360 degrees apart"
            )
        for count in self.cells:
            check_counts(count, 1, f"cells: got {list(self.cells)}")
        if self._closed and self.cells[0] < 3:
            raise ValueError(f"cells: got {list(self.cells)}, allowed: at least 3 around a full ring")
        check_ratios(self.grading, 1, f"grading: got {self.grading}")

    @property
    def _closed(self) -> bool:
        return self.angles[1] - self.angles[0] == 360.0

    def mesh(self, element: Element, level: int) -> Mesh:
        """Counts times `level`; nodes on both circles lie on them."""
        rows = axis(self.radii, self.cells[1], self.grading, level)
        first, last = np.radians(self.angles)

        def place(s: Floats, t: Floats) -> tuple[Floats, Floats]:
            angle, radius = first + t * (last - first), rows(s)
            return radius * np.cos(angle), radius * np.sin(angle)

        mesh = structured(element, (rows.cells, self.cells[0] * level), place)
        mesh = renamed(mesh, {"left": "inner", "right": "outer", "bottom": "start", "top": "end"})
        if not self._closed:
            return mesh
        return welded([renamed(mesh, {"inner": "inner", "outer": "outer"})])


def welded(grids: Iterable[Mesh]) -> Mesh:
    """Mesh of several grids that touch: coincident nodes are merged, edge sets of one name are joined.

    Nodes keep the order in which the grids bring them.
    """
    grids = list(grids)
    first = np.cumsum([0, *(len(grid.nodes) for grid in grids)])
    nodes = np.concatenate([grid.nodes for grid in grids])
    # for every node the lowest node at its place
    from scipy.spatial import cKDTree

    number = np.arange(len(nodes))
    for a, b in sorted(cKDTree(nodes).query_pairs(SAME * float(np.ptp(nodes, axis=0).max()))):
        number[b] = min(number[b], number[a])
    number = number.astype(np.int32)
    kept, final = np.unique(number, return_inverse=True)
    final = final.astype(np.int32)
    edges: dict[str, list[Ints]] = {}
    for grid, begin in zip(grids, first, strict=False):
        for name, some in grid.edges.items():
            edges.setdefault(name, []).append(final[some + begin])
    cells = np.concatenate([final[grid.cells + begin] for grid, begin in zip(grids, first, strict=False)])
    return Mesh(np.ascontiguousarray(nodes[kept]), cells, {name: np.concatenate(some) for name, some in edges.items()})
