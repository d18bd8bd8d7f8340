"""Bodies that go through a rigid surface outside of the contact that they have with it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contactlab.api import Ints, RunWarning
from contactlab.contact.closest import close_pairs, cross
from contactlab.contact.pair import ContactPair
from contactlab.missing_effects.missing_effect import Detectors, needed
from contactlab.missing_effects.overlap import DEPTH, body_of, edge_set
from contactlab.model.model import Model
from contactlab.scene.scene import Scene


def rigid_passages(scene: Scene, model: Model, edges: Ints) -> Detectors:
    """Detector for each rigid surface; `edges` (e, 2) are the edges of all outlines."""
    pairs = model.contact.pairs if model.contact is not None else ()
    joined: dict[str, list[ContactPair]] = {}
    for pair, spec in zip(pairs, scene.contacts, strict=True):
        for name in spec.targets[1]:
            if name in scene.rigid:
                joined.setdefault(name, []).append(pair)
    yield from (Passage(scene, model, edges, name, pairs) for name, pairs in joined.items())


class Passage:
    """`worst`: the end behind a rigid surface of the first edge that crosses it without a contact to it; else -1."""

    def __init__(self, scene: Scene, model: Model, edges: Ints, name: str, pairs: Sequence[ContactPair]) -> None:
        self.scene, self.model, self.name, self.worst = scene, model, name, np.full(1, -1.0)
        self.pairs = pairs
        own = next(support.nodes for support in model.loading.supports if support.on == name)
        segments = pairs[0].master.nodes[pairs[0].master.segments]
        self.surface: Ints = segments[np.isin(segments, own).all(axis=1)]
        self.ends: Ints = np.setxor1d(*self.surface.T)
        slave = np.concatenate([pair.slave.nodes for pair in pairs])
        self.edges: Ints = edges[~np.isin(edges, slave).any(axis=1)]

    def update(self) -> None:
        """The first edge with an end that lies `DEPTH` of the edge behind the segment that it crosses."""
        if self.worst[0] >= 0.0 or not len(self.edges):
            return
        at = self.model.position
        edge, segment = close_pairs(at, self.edges, self.surface)
        (a, b), (c, d) = at[edge].swapaxes(0, 1), at[segment].swapaxes(0, 1)
        along = (d - c) / np.hypot(*(d - c).T)[:, None]
        height = np.stack([cross(a - c, along), cross(b - c, along)], axis=1)
        first, last, long = cross(c - a, b - a), cross(d - a, b - a), np.hypot(*(b - a).T)
        crossed = (height.prod(axis=1) <= 0.0) & (first * last <= 0.0)
        # past the end of a chain: distances of its first and last points from the edge
        beside = np.abs([first, last]) < DEPTH * long**2
        crossed &= ~(np.isin(segment, self.ends) & beside.T).any(axis=1)
        found = np.flatnonzero(crossed & (height.min(axis=1) < -DEPTH * long))
        if len(found):
            self.worst[0] = edge[found[0], height[found[0]].argmin()]

    def warning(self) -> RunWarning | None:
        """Advise a contact between the rigid surface and what crossed it; None if nothing did."""
        node = int(self.worst[0])
        if node < 0:
            return None
        body = body_of(node, self.model)
        x, y = self.model.reference[node]
        edges, own = edge_set(body, node), range(body.first, body.first + body.count)
        key, cure = (
            f"contacts.{len(self.scene.contacts)}",
            f'add [[contacts]] with slave = "{edges}" and master = "{self.name}"',
        )
        for pair in self.pairs:
            if int(pair.slave.nodes[0]) in own:
                key, cure = f"{pair.name}.slave", f'let {pair.name}.slave have the edges there, which are in "{edges}"'
        return needed(
            "contact",
            1.0,
            0.0,
            key,
            f"body {body.name} goes through the rigid surface {self.name}, first seen at its node ({x:.4g}, {y:.4g}), "
            "which is in no contact with it",
            cure,
        )
