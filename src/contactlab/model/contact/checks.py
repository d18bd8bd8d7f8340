"""What two contact surfaces must be to each other before a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.api.arrays import Flags
from contactlab.api.surface import SurfacePositions
from contactlab.errors import SceneError, below
from contactlab.meshing.mesh import outer_edges
from contactlab.model.bodies.body import Body
from contactlab.model.contact.near_list import longest_segment

if TYPE_CHECKING:
    from contactlab.errors import Where

DEEP = 0.1  # segment lengths that a curved surface may cut into another without any overlap of the true shapes
TOO_DEEP = 1.0  # segment lengths beyond which no treatment of an overlap is tried


def check_facing(slave: Surface, master: Surface, positions: Floats, sides: tuple[str, str], where: Where) -> None:
    """Raise SceneError where no part of the slave looks at any part of the master."""
    at, outward = _middles(slave, positions)
    other, other_outward = _middles(master, positions)
    facing = outward @ other_outward.T < -1e-9
    if not facing.any():
        raise SceneError(
            f"{sides[0]} and {sides[1]} turn their backs on each other: no part of one looks at a part of the other",
            where=where,
            got=list(sides),
            allowed="surfaces whose outward normals are opposed somewhere",
            hint="name the edge sets that are to touch; edges have their body on the left",
        )
    reach = _longest(slave, master, positions)
    ahead = np.einsum("si,smi->sm", outward, other[None] - at[:, None])
    if np.all(ahead[facing] < -reach):
        raise SceneError(
            f"{sides[0]} and {sides[1]} look away from each other, or overlap by more than a segment",
            where=where,
            got=f"{-ahead[facing].max():.4g} mm behind each other at the nearest place",
            allowed="surfaces that have each other in front of them",
            hint="name other edge sets, or move a body with shift",
        )


def check_overlap(
    slave: Surface, master: Surface, bodies: tuple[Body, ...], positions: Floats, treated: bool, where: Where
) -> None:
    """Raise SceneError where nodes of one side lie deep inside the body of the other."""
    size = _longest(slave, master, positions)
    for inner, outer in ((slave, master), (master, slave)):
        for body in bodies:
            if not body.first <= outer.nodes[0] < body.first + body.count:
                continue
            nodes = inner.nodes[~_belongs(inner.nodes, body)]
            depth = depths_inside(positions[nodes], positions, outer_edges(body.cells, body.element))
            worst = int(np.argmax(depth)) if len(depth) else 0
            if len(depth) and depth[worst] > (TOO_DEEP if treated else DEEP) * size:
                raise overlap_error(float(depth[worst]), positions[nodes[worst]], body.name, treated, where)


def overlap_error(depth: float, at: Floats, inside: str, treated: bool, where: Where) -> SceneError:
    """The error for surfaces that overlap before the run."""
    return SceneError(
        "slave and master overlap before the run" + (", too deep for any treatment" if treated else ""),
        where=where,
        got=f"{depth:.4g} mm at ({at[0]:.6g}, {at[1]:.6g}), inside {inside}",
        allowed="surfaces that touch or have a gap" + ("" if treated else ", unless the contact says what to do"),
        hint="move a body with shift"
        + ("" if treated else ', or write start = { overlap = "ramp" } or start = { overlap = "adjust" }'),
    )


def refuse_held_slave(slave: Surface, immobile: Flags, name: str, where: Where) -> None:
    """Raise SceneError where no node of the slave can move."""
    if immobile[slave.nodes].all():
        raise SceneError(
            "every node of the slave is held by supports, so its multipliers have nothing to act on",
            where=below(where, "slave"),
            got=name,
            allowed="a slave with nodes that can move",
            hint="exchange the sides: swap = true (or false)",
        )


def _belongs(nodes: Ints, body: Body) -> Flags:
    return np.asarray((nodes >= body.first) & (nodes < body.first + body.count))


def _middles(surface: Surface, positions: Floats) -> tuple[Floats, Floats]:
    """Middle and outward unit normal (s, 2) of every segment."""
    a, b = (positions[surface.nodes[surface.segments[:, i]]] for i in range(2))
    along = b - a
    return 0.5 * (a + b), np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]


def _longest(slave: Surface, master: Surface, positions: Floats) -> float:
    return longest_segment(SurfacePositions(positions[slave.nodes], positions[master.nodes]), slave, master)


def depths_inside(points: Floats, positions: Floats, edges: Ints) -> Floats:
    """Distance (p,) [mm] from points inside a closed boundary (e, 2) to it; 0 outside."""
    a, b = positions[edges[:, 0]], positions[edges[:, 1]]
    along = b - a
    out = np.zeros(len(points))
    for i, point in enumerate(points):
        to_a, to_b = a - point, b - point
        crosses = (to_a[:, 1] <= 0.0) != (to_b[:, 1] <= 0.0)
        left = to_a[:, 0] * to_b[:, 1] - to_a[:, 1] * to_b[:, 0] > 0.0
        winding = np.where(crosses, np.where(to_b[:, 1] > 0.0, left, -1.0 * ~left), 0.0).sum()
        if winding != 0.0:
            share = np.clip(-np.einsum("ei,ei->e", to_a, along) / np.einsum("ei,ei->e", along, along), 0.0, 1.0)
            out[i] = np.hypot(*(to_a + share[:, None] * along).T).min()
    return out
