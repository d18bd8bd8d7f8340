"""Surfaces that meet without a contact between them: they pass through each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Floats, Ints, RunWarning
from contactlab.meshing.inside import windings
from contactlab.meshing.mesh import outer_edges
from contactlab.missing_effects.missing_effect import Detectors, needed
from contactlab.model.bodies.body import Body
from contactlab.model.model import Model
from contactlab.scene.scene import Scene

DEPTH = 0.01  # of a node's edges: how deep it lies in another body before that counts as touching

Mask = NDArray[np.bool_]


def overlap_detectors(scene: Scene, model: Model) -> Detectors:
    """Detector for all pairs of bodies, each body with itself as well, and a detector for each rigid surface."""
    overlap = Overlap(scene, model)
    yield overlap
    if scene.rigid:
        from contactlab.missing_effects.rigid_passage import rigid_passages

        yield from rigid_passages(scene, model, np.concatenate([outline.segments for outline in overlap.outlines]))


class Overlap:
    """`worst`: of the first overlap its node, the body around it, that body's nearest node, how many nodes; else -1.

    The nearest node is looked up immediately: later the first may be nearer to the far side.
    """

    def __init__(self, scene: Scene, model: Model) -> None:
        self.scene, self.model, self.worst = scene, model, np.full(4, -1.0)
        self.outlines = [Outline(body) for body in model.bodies]
        self.joined = _joined_nodes(self.outlines, model)

    def update(self) -> None:
        """Boundary nodes of each body inside any body that no contact joins them to."""
        if self.worst[0] >= 0.0:
            return
        position = self.model.position
        boxes = np.array([outline.box(position) for outline in self.outlines])
        for first, second in zip(*meeting(boxes), strict=True):
            one, other = self.outlines[first], self.outlines[second]
            joined = self.joined.get((first, second))
            free = np.arange(len(one.nodes)) if joined is None else np.flatnonzero(~joined)
            found = one.inside(other, free, position)
            if len(found):
                self.worst[:] = found[0], second, other.nearest(position[found[0]], position), len(found)
                return

    def warning(self) -> RunWarning | None:
        """Advise a contact between two bodies that overlap; None while none do."""
        node, number, opposite, count = (int(value) for value in self.worst)
        if node < 0:
            return None
        other = self.outlines[number].body
        body = body_of(node, self.model)
        x, y = self.model.reference[node]
        met = "itself" if body is other else f"body {other.name}"
        slave, master = edge_set(body, node), edge_set(other, opposite)
        return needed(
            "contact",
            count,
            0.0,
            f"contacts.{len(self.scene.contacts)}",
            f"body {body.name} runs into {met}, first seen at its node ({x:.4g}, {y:.4g}), and no contact joins them",
            f'add [[contacts]] with slave = "{slave}" and master = "{master}"',
        )


def body_of(node: int, model: Model) -> Body:
    """The body that has a node."""
    return next(body for body in model.bodies if body.first <= node < body.first + body.count)


def edge_set(body: Body, node: int) -> str:
    """A named edge set of the body that has the node, the shortest; "body" if none has."""
    sets = {name: edges for name, edges in body.mesh.edges.items() if node - body.first in edges}
    name = min(sets, key=lambda name: len(sets[name]), default="")
    return f"{body.name}.{name}" if name else body.name


class Outline:
    """The boundary of a body: straight segments (e, 2) of global nodes, the body on their left."""

    def __init__(self, body: Body) -> None:
        self.body = body
        self.segments: Ints = outer_edges(body.cells, body.element)
        self.nodes, ends = np.unique(self.segments, return_inverse=True)
        order = np.argsort(ends.ravel(), kind="stable")
        # the edges that meet at each node, one node after the other
        self.edges, self.starts = order // 2, np.searchsorted(ends.ravel()[order], np.arange(len(self.nodes)))

    def box(self, position: Floats) -> Floats:
        """The box around it: low x, low y, high x, high y."""
        at = position[self.nodes]
        return np.concatenate([at.min(axis=0), at.max(axis=0)])

    def inside(self, other: Outline, free: Ints, position: Floats) -> Ints:
        """Boundary nodes of those in `free` that lie `DEPTH` of an edge inside `other` (or fold back into the body)."""
        nodes, outward = self.nodes[free], self.outward(position)
        # inwards: how much of this body lies in the other; outwards: where nothing of itself may be
        probe = position[nodes] + outward[free] if other is self else position[nodes] - outward[free]
        return np.asarray(nodes[windings(probe, position, other.segments) > 0.0])

    def outward(self, position: Floats) -> Floats:
        """`DEPTH` of the shortest edge of each boundary node (k, 2), along its outward normal."""
        edge = position[self.segments[:, 1]] - position[self.segments[:, 0]]
        length = np.hypot(edge[:, 0], edge[:, 1])
        normals = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / length[:, None]
        total = np.add.reduceat(normals[self.edges], self.starts)
        size = np.minimum.reduceat(length[self.edges], self.starts)
        return np.asarray((DEPTH * size / np.maximum(np.hypot(total[:, 0], total[:, 1]), 1e-300))[:, None] * total)

    def nearest(self, point: Floats, position: Floats) -> int:
        """Find the boundary node nearest to a point."""
        return int(self.nodes[((position[self.nodes] - point) ** 2).sum(axis=1).argmin()])


def meeting(boxes: Floats) -> tuple[Ints, Ints]:
    """Pairs of boxes (n, 4) with a point in common, in both orders and each box with itself, sorted."""
    count, (low, high) = len(boxes), (boxes[:, :2], boxes[:, 2:])
    axis = int(np.argmax(high.max(axis=0) - low.min(axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    ends = np.searchsorted(low[order, axis], high[order, axis], side="right")
    behind = ends - np.arange(count) - 1  # boxes that begin before this one ends, along the longer axis
    first = np.repeat(np.arange(count), behind)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(behind) - behind, behind)
    a, b = order[first], order[second]
    near = ((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)
    a, b, same = a[near], b[near], np.arange(count)
    pairs = np.unique(np.stack([np.concatenate([a, b, same]), np.concatenate([b, a, same])], axis=1), axis=0)
    return pairs[:, 0], pairs[:, 1]


def _joined_nodes(outlines: Sequence[Outline], model: Model) -> dict[tuple[int, int], Mask]:
    """Masks of a body's boundary nodes in a contact whose other side is (partly) of another, by both numbers."""
    ends = np.array([outline.body.first + outline.body.count for outline in outlines])
    joined: dict[tuple[int, int], Mask] = {}
    for pair in model.contact.pairs if model.contact is not None else ():
        for one, opposite in ((pair.slave, pair.master), (pair.master, pair.slave)):
            others = np.unique(np.searchsorted(ends, opposite.nodes[opposite.nodes < ends[-1]], side="right"))
            of = np.searchsorted(ends, one.nodes, side="right")
            for number in np.unique(of[of < len(outlines)]).tolist():
                outline = outlines[number]
                seen = np.isin(outline.nodes, one.nodes[of == number])
                for other in others.tolist():
                    joined[number, other] = joined.get((number, other), False) | seen
    return joined
