"""Surfaces that meet without a contact between them: they pass through each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Floats, Ints, RunWarning
from contactlab.meshing.inside import windings
from contactlab.meshing.mesh import outer_edges
from contactlab.missing_effects.missing_effect import Detectors, needed
from contactlab.model.bodies.body import Body
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene

DEPTH = 0.01  # of a node's edges: how deep it lies in another body before that counts as touching

Mask = NDArray[np.bool_]


def overlap_detectors(scene: Scene, model: Model) -> Detectors:
    """One detector for all pairs of bodies, each body with itself as well."""
    yield Overlap(scene, model)


class Overlap:
    """`worst`: of the first overlap its node, the body around it, that body's nearest node, how many nodes; else -1.

    The nearest node is looked up at once: later the first may be nearer to the far side.
    """

    def __init__(self, scene: Scene, model: Model) -> None:
        self.scene, self.model, self.worst = scene, model, np.full(4, -1.0)
        self.outlines = [Outline(body, model) for body in model.bodies]

    def update(self) -> None:
        """Boundary nodes of each body inside any body that no contact joins them to."""
        if self.worst[0] >= 0.0:
            return
        for one in self.outlines:
            for number, other in enumerate(self.outlines):
                found = one.inside(other, self.model.position)
                if len(found):
                    at = self.model.position[found[0]]
                    self.worst[:] = found[0], number, other.nearest(at, self.model.position), len(found)
                    return

    def warning(self) -> RunWarning | None:
        """Advise a contact between two bodies that overlap; None while none do."""
        node, number, opposite, count = (int(value) for value in self.worst)
        if node < 0:
            return None
        other = self.outlines[number].body
        body = next(b for b in self.model.bodies if b.first <= node < b.first + b.count)
        x, y = self.model.reference[node]
        met = "itself" if body is other else f"body {other.name}"
        slave, master = _edge_set(body, node), _edge_set(other, opposite)
        return needed(
            "contact",
            count,
            0.0,
            f"contacts.{len(self.scene.contacts)}",
            f"body {body.name} runs into {met}, first seen at its node ({x:.4g}, {y:.4g}), and no contact joins them",
            f'add [[contacts]] with slave = "{slave}" and master = "{master}"',
        )


def _edge_set(body: Body, node: int) -> str:
    """A named edge set of the body that has the node, the shortest; "body" where none has."""
    sets = {name: edges for name, edges in body.mesh.edges.items() if node - body.first in edges}
    name = min(sets, key=lambda name: len(sets[name]), default="")
    return f"{body.name}.{name}" if name else body.name


class Outline:
    """The boundary of a body: straight segments (e, 2) of global nodes, the body on their left."""

    def __init__(self, body: Body, model: Model) -> None:
        self.body = body
        self.segments: Ints = outer_edges(body.cells, body.element)
        self.nodes = np.unique(self.segments)
        self.local = np.searchsorted(self.nodes, self.segments)
        self.joined = {other.name: _joined(self.nodes, other, model) for other in model.bodies}

    def inside(self, other: Outline, position: Floats) -> Ints:
        """Boundary nodes that lie `DEPTH` of an edge inside `other` (or fold back into this body itself)."""
        free = self.nodes[~self.joined[other.body.name]]
        if not len(free):
            return free
        normal, size = self._normals(position)
        # inwards: how much of this body lies in the other; outwards: where nothing of itself may be
        way = 1.0 if other is self else -1.0
        probe = (position[self.nodes] + way * DEPTH * size[:, None] * normal)[~self.joined[other.body.name]]
        return np.asarray(free[windings(probe, position, other.segments) > 0.0])

    def _normals(self, position: Floats) -> tuple[Floats, Floats]:
        """Outward unit normal (k, 2) of each boundary node, and the shortest of its edges (k,)."""
        edge = position[self.segments[:, 1]] - position[self.segments[:, 0]]
        length = np.hypot(*edge.T)
        outward = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / length[:, None]
        total, size = np.zeros((len(self.nodes), 2)), np.full(len(self.nodes), np.inf)
        for end in range(2):
            np.add.at(total, self.local[:, end], outward)
            np.minimum.at(size, self.local[:, end], length)
        return total / np.maximum(np.hypot(*total.T), 1e-300)[:, None], size

    def nearest(self, point: Floats, position: Floats) -> int:
        """Find the boundary node nearest to a point."""
        return int(self.nodes[((position[self.nodes] - point) ** 2).sum(axis=1).argmin()])


def _joined(nodes: Ints, other: Body, model: Model) -> Mask:
    """Which of the nodes belong to a contact whose other side is (partly) of body `other`."""
    joined = np.zeros(len(nodes), np.bool_)
    for pair in model.contact.pairs if model.contact is not None else ():
        for one, opposite in ((pair.slave, pair.master), (pair.master, pair.slave)):
            if np.any((opposite.nodes >= other.first) & (opposite.nodes < other.first + other.count)):
                joined |= np.isin(nodes, one.nodes)
    return joined
