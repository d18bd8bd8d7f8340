"""Meshes that are open inside: sides of cells that lie on each other and share no nodes, so that nothing joins them.

Such a slit results from geometry drawn twice (nodes on nodes) or refined cells next to coarse cells (hanging nodes).
The body is too soft there, and no later step can distinguish it from a crack that is intended. So it is refused,
unless a contact of the body joins both of its sides: then it is intended.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from contactlab.api import Element, Floats, Ints, Mesh
from contactlab.errors import SceneError, Where
from contactlab.meshing.mesh import outer_sides, segments_of

CLOSED = 0.01  # of the size of the adjacent cells: a narrower gap counts as closed, as for bodies without a contact
CURVED = 1.2  # of the depth of facets: how far nodes of a curve lie from the sides of a coarser division of it
THIN = 0.25  # of the size of the cells: the same at most, so that sides of a thin curved shell are not a slit
BACK = -0.8  # cosine between both sides of a slit, which run in opposite directions
BEND = 0.6  # rad: a sharper turn between two sides is a corner

Pairs = Sequence[tuple[Sequence[str], Sequence[str]]]


def check_closed(mesh: Mesh, element: Element, joined: Pairs, where: Where) -> None:
    """Raise SceneError for sides that lie on each other without common nodes.

    joined  names of edge sets of this body that are slave and master of one contact: their sides may lie on each other
    """
    sides = _Sides(mesh, element)
    one, other = sides.on_each_other()
    meant = np.zeros(len(one), np.bool_)
    for slave, master in joined:
        of_slave, of_master = (sides.within(names) for names in (slave, master))
        meant |= (of_slave[one] & of_master[other]) | (of_master[one] & of_slave[other])
    if meant.all():
        return
    twice, hanging = sides.loose_nodes(one[~meant], other[~meant])
    found = np.unique(np.concatenate([twice, hanging]))
    if not len(found):
        return
    places = mesh.nodes[found]
    first, last = places[np.lexsort(places.T[::-1])[[0, -1]]]
    kinds = [f"{len(twice)} coincide with other nodes"] if len(twice) else []
    kinds += [f"{len(hanging)} are hanging nodes on sides of other cells"] if len(hanging) else []
    raise SceneError(
        f"the mesh has a slit inside: {len(found)} nodes on both sides of it are not joined",
        where=where,
        got=f"{' and '.join(kinds)}, from ({first[0]:.6g}, {first[1]:.6g}) to ({last[0]:.6g}, {last[1]:.6g})",
        allowed="cells that share the nodes between them, or a contact between both sides of the slit",
        hint="merge coincident nodes (gmsh.model.mesh.removeDuplicateNodes()) and divide both sides of the line "
        "equally; for an intended slit, name its sides as edge sets and add a contact between them",
    )


class _Sides:
    """Straight segments of a mesh's boundary, the body on their left, and what is near enough to count as closed."""

    def __init__(self, mesh: Mesh, element: Element) -> None:
        self.mesh, self.nodes = mesh, mesh.nodes
        sides, cells = outer_sides(mesh.cells, element)
        self.ends, self.cell = segments_of(sides), np.tile(cells, sides.shape[1] - 1)
        self.begin, end = self.nodes[self.ends[:, 0]], self.nodes[self.ends[:, 1]]
        self.along = end - self.begin
        self.length = np.maximum(np.hypot(*self.along.T), 1e-300)
        corners = self.nodes[mesh.cells[np.ix_(self.cell, np.array([edge[0] for edge in element.edges]))]]
        x, y = corners[..., 0] - corners[:, :1, 0], corners[..., 1] - corners[:, :1, 1]
        area = 0.5 * np.abs((x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1))
        self.size = np.minimum(self.length, area / self.length)
        self.depth = self._facet_depths()

    def _facet_depths(self) -> Floats:
        """Distance (e,) of a smooth curve through the boundary from each segment: length times turn over 8.

        If several segments begin at a node, as at the end of a slit, the straightest continues the curve.
        """
        out = np.argsort(self.ends[:, 0], kind="stable")
        start = np.searchsorted(self.ends[out, 0], self.ends[:, 1])
        count = np.searchsorted(self.ends[out, 0], self.ends[:, 1], side="right") - start
        turn, after = np.full(len(self.ends), np.inf), np.zeros(len(self.ends), np.int64)
        for number in range(int(count.max(initial=0))):
            own = np.flatnonzero(count > number)
            candidate = out[start[own] + number]
            a, b = self.along[own], self.along[candidate]
            angle = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)))
            better = angle < turn[own]
            turn[own[better]], after[own[better]] = angle[better], candidate[better]
        turn[turn > BEND] = 0.0
        behind = np.zeros(len(self.ends))
        np.maximum.at(behind, after, turn)
        return np.asarray(self.length * np.maximum(turn, behind) / 8.0)

    def on_each_other(self) -> tuple[Any, Any]:
        """Pairs of segments the middle of the first of which lies on the second, which runs the other way."""
        middle = self.begin + 0.5 * self.along
        reach = ((CLOSED + THIN) * self.size)[:, None]
        corners = np.stack([self.begin, self.begin + self.along])
        one, other = points_in_boxes(middle, corners.min(axis=0) - reach, corners.max(axis=0) + reach)
        some = self.cell[one] != self.cell[other]
        one, other = one[some], other[some]
        cosine = (self.along[one] * self.along[other]).sum(axis=1) / (self.length[one] * self.length[other])
        near = self._distance(middle[one], other) <= self._tolerance(one, other)
        found = near & (cosine < BACK)
        return one[found], other[found]

    def _tolerance(self, one: Any, other: Any) -> Floats:
        size = np.minimum(self.size[one], self.size[other])
        curved = CURVED * (self.depth[one] + self.depth[other])
        return np.asarray(CLOSED * size + np.minimum(curved, THIN * size))

    def _distance(self, points: Floats, segments: Any) -> Floats:
        along, to = self.along[segments], points - self.begin[segments]
        share = np.clip((to * along).sum(axis=1) / self.length[segments] ** 2, 0.0, 1.0)
        return np.asarray(np.hypot(*(to - share[:, None] * along).T))

    def within(self, names: Sequence[str]) -> Any:
        """Mask (e,) of the segments in some edge sets."""
        count = len(self.nodes)
        wanted = [segments_of(self.mesh.edges[name]) for name in names if name in self.mesh.edges]
        keys = [part[:, 0].astype(np.int64) * count + part[:, 1] for part in wanted]
        own = self.ends[:, 0].astype(np.int64) * count + self.ends[:, 1]
        return np.isin(own, np.concatenate([np.zeros(0, np.int64), *keys]))

    def loose_nodes(self, one: Any, other: Any) -> tuple[Ints, Ints]:
        """Nodes of the first segments that lie on other nodes of the second ones, and those that lie between these."""
        twice, hanging = [], []
        reach = self._tolerance(one, other)
        for place in (0, 1):
            node = self.ends[one, place]
            apart = np.hypot(*(self.nodes[node][:, None] - self.nodes[self.ends[other]]).transpose(2, 0, 1))
            nearest = np.take_along_axis(self.ends[other], apart.argmin(axis=1)[:, None], axis=1)[:, 0]
            on_node = apart.min(axis=1) <= reach
            twice.append(node[on_node & (nearest != node)])
            hanging.append(node[~on_node & (self._distance(self.nodes[node], other) <= reach)])
        both = np.unique(np.concatenate(twice))
        return both, np.setdiff1d(np.concatenate(hanging), both)


def points_in_boxes(points: Floats, low: Floats, high: Floats) -> tuple[Any, Any]:
    """Pairs of a point (p, 2) and a box (b, 2) that it lies in, in a time that grows with their numbers alone.

    Boxes are sorted by size, and points into squares as large as the boxes of each size: a box lies in at most four.
    """
    size = np.maximum((high - low).max(axis=1), 1e-300)
    extent = float(max(np.ptp(points, axis=0).max(initial=0.0), 1e-300))
    kind = np.floor(np.log2(np.maximum(size, 1e-9 * extent))).astype(np.int64)
    origin = points.min(axis=0, initial=np.inf)
    found: list[tuple[Any, Any]] = []
    for power in np.unique(kind):
        width = 2.0 ** float(power + 1)
        boxes = np.flatnonzero(kind == power)
        column, row = np.floor((points - origin) / width).astype(np.int64).T
        rows = int(row.max()) + 1
        square = column * rows + row
        order = np.argsort(square, kind="stable")
        first, last = (np.floor((corner[boxes] - origin) / width).astype(np.int64) for corner in (low, high))
        for right, up in ((0, 0), (0, 1), (1, 0), (1, 1)):
            at = first + np.array([right, up])
            own = (at <= last).all(axis=1) & (at >= 0).all(axis=1) & (at[:, 1] < rows)
            wanted = at[own, 0] * rows + at[own, 1]
            start, stop = (np.searchsorted(square[order], wanted, side=side) for side in ("left", "right"))
            count = stop - start
            skip = np.repeat(start - np.concatenate([[0], np.cumsum(count)[:-1]]), count)
            point, box = order[skip + np.arange(int(count.sum()))], np.repeat(boxes[own], count)
            inside = ((points[point] >= low[box]) & (points[point] <= high[box])).all(axis=1)
            found.append((point[inside], box[inside]))
    return np.concatenate([p for p, _ in found]), np.concatenate([b for _, b in found])
