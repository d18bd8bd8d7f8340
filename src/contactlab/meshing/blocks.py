"""Blocks: one structured grid each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from contactlab.api import Element, Floats, Mesh, MeshSource
from contactlab.api.meshing import renamed, structured
from contactlab.meshing.grading import Counts, Ratios, axis, check_axis, check_counts, check_ratios

Point = tuple[float, float]


@dataclass(frozen=True)
class Rectangle(MeshSource):
    """A rectangle of quadrilaterals with edge sets bottom, right, top, left.

    x, y     two or more increasing coordinates in each direction [mm]: the corners, and between them the
             ends of spans with cell counts of their own
    cells    columns and rows at level 1; a list instead of a number gives the count of each span
    grading  last over first cell size in x and in y [-]; a list gives one for each span
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    cells: tuple[Counts, Counts]
    grading: tuple[Ratios, Ratios] = (1.0, 1.0)

    def __post_init__(self) -> None:
        check_axis("x", self.x, 0, self.cells[0], self.grading[0])
        check_axis("y", self.y, 1, self.cells[1], self.grading[1])

    def mesh(self, element: Element, level: int) -> Mesh:
        """The mesh, with `level` times as many cells in each direction."""
        along_x = axis(self.x, self.cells[0], self.grading[0], level)
        along_y = axis(self.y, self.cells[1], self.grading[1], level)
        return structured(element, (along_x.cells, along_y.cells), lambda s, t: (along_x(s), along_y(t)))


LARGEST = 1e150  # mm, of a radius


@dataclass(frozen=True)
class ArcBlock(MeshSource):
    """The region between the arc y = radius - sqrt(radius^2 - x^2), |x| <= half_width, and the flat y = top.

    Nodes are linear in y within a column; the lowest point of the arc is the origin. Edge sets arc,
    right, top, left.

    radius      of the arc [mm]
    half_width  [mm], at most the radius
    top         height of the flat top above the lowest point [mm]
    cells       columns and rows at level 1; the columns are of equal width
    grading     from the middle outwards, and from the arc upwards, last over first cell size [-]
    """

    radius: float
    half_width: float
    top: float
    cells: tuple[int, int]
    grading: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        _check_grid(self.cells, self.grading)
        if not self.radius < LARGEST:
            raise ValueError(f"radius: got {self.radius}, allowed: below {LARGEST:g}, a number that can be squared")
        if not 0.0 < self.half_width <= self.radius:
            raise ValueError(f"half_width: got {self.half_width}, allowed: 0 < half_width <= radius = {self.radius}")
        if not self.top > self._arc(self.half_width):
            raise ValueError(f"top: got {self.top}, allowed: above the end of the arc, {self._arc(self.half_width):g}")
        if self.grading[0] != 1.0 and self.cells[0] % 2:
            raise ValueError(f"cells: got {list(self.cells)}, allowed: an even number of columns if they are graded")

    def _arc(self, x: Floats | float) -> Floats:
        return np.asarray(self.radius - np.sqrt(self.radius**2 - np.asarray(x) ** 2))

    def mesh(self, element: Element, level: int) -> Mesh:
        """Counts times `level`; nodes on the lower side lie on the true arc."""
        w, graded = self.half_width, self.grading[0]
        if graded == 1.0:
            columns = axis((-w, w), self.cells[0], 1.0, level)
        else:
            half = self.cells[0] // 2
            columns = axis((-w, 0.0, w), (half, half), (1.0 / graded, graded), level)
        rows = axis((0.0, 1.0), self.cells[1], self.grading[1], level)

        def place(s: Floats, t: Floats) -> tuple[Floats, Floats]:
            x = columns(s)
            low = self._arc(x)
            return x, low + rows(t) * (self.top - low)

        mesh = structured(element, (columns.cells, rows.cells), place)
        return renamed(mesh, {"bottom": "arc", "right": "right", "top": "top", "left": "left"})


@dataclass(frozen=True)
class QuadBlock(MeshSource):
    """A block between four corners, sides straight or circular arcs; edge sets bottom, right, top, left.

    corners  counter-clockwise [mm]; bottom joins the first two, right the next two, and so on
    cells    along bottom and top, and along right and left, at level 1
    bulge    height of the arc over the middle of bottom, right, top, left [mm], positive outwards; 0 is straight
    grading  from left to right and from bottom to top, last over first cell size [-]
    """

    corners: tuple[Point, Point, Point, Point]
    cells: tuple[int, int]
    bulge: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    grading: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        _check_grid(self.cells, self.grading)
        x = np.asarray(self.corners)
        ahead, back = np.roll(x, -1, axis=0) - x, np.roll(x, 1, axis=0) - x
        if not np.all(ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0] > 0.0):
            raise ValueError(
                f"corners: got {[list(c) for c in self.corners]}, allowed: a convex block, counter-clockwise"
            )
        half = 0.5 * np.hypot(*ahead.T)
        if not np.all(np.abs(self.bulge) <= half):
            raise ValueError(
                f"bulge: got {list(self.bulge)}, allowed: at most half the length of each side, {half.tolist()}"
            )

    def mesh(self, element: Element, level: int) -> Mesh:
        """Counts times `level`; nodes on the sides lie on the true arcs, inner ones by transfinite interpolation."""
        a, b, c, d = (np.asarray(corner) for corner in self.corners)
        bottom, right, top, left = self.bulge
        along = axis((0.0, 1.0), self.cells[0], self.grading[0], level)
        across = axis((0.0, 1.0), self.cells[1], self.grading[1], level)

        def place(u: Floats, v: Floats) -> tuple[Floats, Floats]:
            s, t = along(u)[:, None], across(v)[:, None]
            # both sides of a direction run the same way, so top and left are reversed: outwards is on their left
            rows = (1.0 - t) * arc_point(a, b, bottom, s) + t * arc_point(d, c, -top, s)
            columns = (1.0 - s) * arc_point(a, d, -left, t) + s * arc_point(b, c, right, t)
            corners = (1.0 - t) * ((1.0 - s) * a + s * b) + t * ((1.0 - s) * d + s * c)
            x = rows + columns - corners
            return x[:, 0], x[:, 1]

        return structured(element, (along.cells, across.cells), place)


def arc_point(a: Floats, b: Floats, bulge: float, s: Floats) -> Floats:
    """Points (k, 2) at fractions s (k, 1) of the arc from a to b that rises by `bulge` [mm] on the right of a to b."""
    chord = b - a
    if bulge == 0.0:
        return np.asarray(a + s * chord)
    length = math.hypot(*chord)
    # half the angle of the arc from its rise over half the chord
    half = 2.0 * math.atan2(2.0 * abs(bulge), length)
    radius = 0.5 * length / math.sin(half)
    outward = np.array([chord[1], -chord[0]]) / length * math.copysign(1.0, bulge)
    centre = 0.5 * (a + b) - outward * radius * math.cos(half)
    angle = half * (2.0 * s - 1.0)
    return np.asarray(centre + radius * (np.sin(angle) * chord / length + np.cos(angle) * outward))


def _check_grid(cells: tuple[int, int], grading: tuple[float, float]) -> None:
    for place in range(2):
        check_counts(cells[place], 1, f"cells: got {list(cells)}")
        check_ratios(grading[place], 1, f"grading: got {list(grading)}")
