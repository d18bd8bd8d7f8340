"""Shares of nodes in the area of bodies, or in the length of edge sets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.errors import SceneError
from contactlab.meshing.mesh import nodal_measure
from contactlab.model.bodies.body import Body
from contactlab.model.loading.edge_integrals import Edges, uniform
from contactlab.model.loading.edge_sets import edge_set

if TYPE_CHECKING:
    from contactlab.errors import Where


def shares_of(bodies: tuple[Body, ...], reference: Floats, names: Sequence[str], where: Where) -> tuple[Ints, Floats]:
    """Nodes (k,) of bodies or of edge sets, and the share (k,) of the whole area or length that each stands for.

    An area is that of the lumped mass, a length the integral of the node's trace function. A body or an edge that is
    named twice counts once. Raises SceneError for bodies beside edge sets.
    """
    measure = np.zeros(len(reference))
    whole = [body for body in bodies if body.name in names]
    for body in whole:
        measure[body.first : body.first + body.count] = nodal_measure(body.mesh, body.element)
    if not whole:
        found = [edge_set(bodies, name, where) for name in names]
        for body in bodies:
            own = [edges for other, edges in found if other is body]
            if own:
                sides = np.unique(np.concatenate(own), axis=0)
                along, points = Edges(body.element, sides, reference), uniform(len(sides))
                shape, _ = along.trace(points)
                length = points.weight * along.speed(points.edge, points.at)
                np.add.at(measure, sides[points.edge], length[:, None] * shape)
    elif other := [name for name in names if name not in {body.name for body in whole}]:
        edge_set(bodies, other[0], where)
        raise SceneError(
            "bodies and edge sets in one list", where=where, got=list(names),
            allowed="bodies, which share by area, or edge sets, which share by length", hint="write a table for each",
        )  # fmt: skip
    nodes = np.flatnonzero(measure).astype(np.int32)
    return nodes, measure[nodes] / measure.sum()
