"""Checks of two contact surfaces against each other before a run."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api import Enforcement, Floats, FrictionLaw, NormalLaw, Surface
from contactlab.api.arrays import Flags
from contactlab.api.surface import SurfacePositions
from contactlab.errors import PartError, SceneError, Where, below
from contactlab.kernels.contact.search import longest_segment
from contactlab.meshing.inside import depths_inside
from contactlab.meshing.mesh import outer_edges
from contactlab.model.bodies.body import Body
from contactlab.parts.registry import split_spec

DEEP = 0.1  # segment lengths that a curved surface may cut into another without any overlap of the true shapes
FACING = 64  # slave segments, from all over the surface, compared with all of the master at a time
ROUND = 1e-9  # relative
LAWS = "linear-pressure, exponential-pressure, tabular-pressure"
ALIKE = 0.5  # cosine of the angle between normals of sides that look the same way
FACETS = 0.1  # of the longest segment: how far facets of one curve stand in front of another
TOO_DEEP = 1.0  # segment lengths beyond which no treatment of an overlap is tried


def check_facing(slave: Surface, master: Surface, positions: Floats, sides: tuple[str, str], where: Where) -> None:
    """Raise SceneError if no part of the slave faces any part of the master."""
    reach = _longest(slave, master, positions)
    nearest = _most_ahead(_middles(slave, positions), _middles(master, positions), -reach)
    if nearest == -np.inf:
        raise SceneError(
            f"{sides[0]} and {sides[1]} face away from each other: no pair of segments has opposed normals",
            where=where,
            got=list(sides),
            allowed="surfaces whose outward normals are opposed somewhere",
            hint="name the edge sets that are to touch; edges have their body on the left",
        )
    if nearest < -reach:
        raise SceneError(
            f"{sides[0]} and {sides[1]} face away from each other, or overlap by more than a segment",
            where=where,
            got=f"{-nearest:.4g} mm behind each other at the nearest place",
            allowed="surfaces that have each other in front of them",
            hint="name other edge sets, or move a body with shift",
        )


def _most_ahead(slave: tuple[Floats, Floats], master: tuple[Floats, Floats], enough: float) -> float:
    """Return how far the master lies ahead of the slave, the most of all facing segments; -inf if none face.

    Slave segments are processed in groups from all over the surface, and the search ends when `enough` is found: a
    correct surface costs memory and time in proportion to its segments, a wrong surface time alone.
    """
    (at, outward), (other, other_outward) = slave, master
    strides = max(1, len(at) // FACING)
    most = -np.inf
    for first in range(strides):
        some = slice(first, None, strides)
        ahead = outward[some] @ other.T - np.einsum("si,si->s", outward[some], at[some])[:, None]
        facing = outward[some] @ other_outward.T < -1e-9
        most = max(most, float(ahead.max(initial=-np.inf, where=facing)))
        if most >= enough:
            break
    return most


def check_solid_side(
    slave: Surface, rigid: Mapping[str, Floats], masters: tuple[str, ...], positions: Floats, side: str, where: Where
) -> None:
    """Raise SceneError if all of the slave lies in the solid of a rigid surface: its points run the wrong way.

    rigid  (s, 2, 2) [mm] ends of the segments of each rigid surface of the scene, of which some are `masters`
    """
    for name in masters:
        if name in rigid and (depth := _depth_behind(slave, name, rigid, positions)) is not None:
            raise SceneError(
                f"all of {side} lies in the solid of the rigid surface {name}",
                where=where,
                got=f"nodes up to {depth:.4g} mm behind it, none in front",
                allowed="a rigid surface whose solid is on its left, as one goes along its points",
                hint=f"write the points of rigid.{name} in the reverse order, or the angles of its arc",
            )


def _depth_behind(slave: Surface, name: str, rigid: Mapping[str, Floats], positions: Floats) -> float | None:
    """Return how deep [mm] a slave lies in the solid of a surface; None if some of it is in front or may overlap.

    Points in front of other faces of the same solid, on them or past an end count as neither. Less than a segment is an
    overlap, unless the nearest segment faces the same way as the surface.
    """
    line = rigid[name]
    others = np.concatenate([np.zeros((0, 2, 2)), *(rigid[other] for other in rigid if other != name)])
    ends, (middle, outward) = positions[slave.nodes[slave.segments]], _middles(slave, positions)
    points = positions[slave.nodes]
    longest = max(float(np.hypot(*(one[:, 1] - one[:, 0]).T).max()) for one in (ends, line))
    for some in (points[:: max(1, len(points) // FACING)], points, middle):
        height, feet, normals = _heights(some, line)
        counts = ~_behind_others(some, feet, others) & ~_beyond(some, feet, normals, line)
        # one of two curves that face the same way has facets in front of the other
        slight = height <= FACETS * longest
        if some is middle:
            slight &= (outward * normals).sum(axis=1) > ALIKE
        if not counts.any() or (counts & ~slight & (height > ROUND * np.abs(height).max())).any():
            return None
        if some is points:
            deepest = abs(float(height[counts].min()))
    nearest = np.flatnonzero(counts)[height[counts].argmax()]
    turned = float(outward[nearest] @ normals[nearest]) > ALIKE
    return deepest if turned or deepest > TOO_DEEP * longest else None


def _beyond(points: Floats, nearest: Floats, normals: Floats, line: Floats) -> Flags:
    """Return whether each point lies past a free end of an open curve, along it: a facet there says nothing of it."""
    begin, end = line[0, 0], line[-1, 1]
    if np.array_equal(begin, end):
        return np.zeros(len(points), dtype=bool)
    slight = ROUND * float(np.abs(line).max())
    at_end = np.logical_or(*(np.hypot(*(nearest - one).T) <= slight for one in (begin, end)))
    across = (points - nearest) - ((points - nearest) * normals).sum(axis=1)[:, None] * normals
    return np.asarray(at_end & (np.hypot(*across.T) > slight))


def _behind_others(points: Floats, nearest: Floats, segments: Floats) -> Flags:
    """Return whether the line from each point to its nearest place (n, 2) enters the solid of a segment (s, 2, 2)."""
    a, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
    before, after = (np.einsum("nsi,si->ns", at[:, None] - a, outward) for at in (points, nearest))
    size = (along**2).sum(axis=1)
    enters = (before >= -ROUND * size) & (after <= ROUND * size)
    share = np.divide(before, before - after, out=np.zeros_like(before), where=enters & (before > after))
    at = points[:, None] + share[..., None] * (nearest - points)[:, None]
    place = np.einsum("nsi,si->ns", at - a, along) / size
    return np.asarray((enters & (np.abs(place - 0.5) <= 0.5 + ROUND)).any(axis=1))


def _heights(points: Floats, segments: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the height [mm] of each point over the nearest of the segments (s, 2, 2), below zero on its left.

    With the nearest places (n, 2) [mm], and the segments' outward normals (n, 2) there.
    """
    a, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.hypot(*along.T)
    out, feet, normals = np.empty(len(points)), np.empty((len(points), 2)), np.empty((len(points), 2))
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    for number, point in enumerate(points):
        share = np.clip(((point - a) * along).sum(axis=1) / length**2, 0.0, 1.0)
        apart = point - a - share[:, None] * along
        distance = np.hypot(*apart.T)
        height = (apart[:, 0] * along[:, 1] - apart[:, 1] * along[:, 0]) / length
        nearest = np.flatnonzero(distance <= distance.min() * (1.0 + ROUND))
        best = nearest[np.abs(height[nearest]).argmax()]  # two at a vertex: the segment that faces the point best
        out[number], feet[number], normals[number] = height[best], point - apart[best], outward[best]
    return out, feet, normals


def check_overlap(
    slave: Surface, master: Surface, bodies: tuple[Body, ...], positions: Floats, treated: bool, where: Where
) -> None:
    """Raise SceneError if nodes of one side lie deep inside the body of the other."""
    size = _longest(slave, master, positions)
    for inner, outer in ((slave, master), (master, slave)):
        number = bisect_right(bodies, outer.nodes[0], key=lambda body: body.first + body.count)
        for body in bodies[number : number + 1]:  # none for a rigid surface
            nodes = inner.nodes[(inner.nodes < body.first) | (inner.nodes >= body.first + body.count)]
            depth = depths_inside(positions[nodes], positions, outer_edges(body.cells, body.element))
            worst = int(np.argmax(depth)) if len(depth) else 0
            if len(depth) and depth[worst] > (TOO_DEEP if treated else DEEP) * size:
                raise overlap_error(float(depth[worst]), positions[nodes[worst]], body.name, treated, where)


def overlap_error(depth: float, at: Floats, inside: str, treated: bool, where: Where) -> SceneError:
    """Return the error for surfaces that overlap before the run."""
    hint = "move a body with shift"
    if not treated:
        hint += (
            ', or write start = { overlap = "ramp" } or { overlap = "adjust" }, or { gap = "zero" } if '
            "curved sides fit and their facets alone overlap"
        )
    return SceneError(
        "slave and master overlap before the run" + (", too deep for any treatment" if treated else ""),
        where=where,
        got=f"{depth:.4g} mm at ({at[0]:.6g}, {at[1]:.6g}), inside {inside}",
        allowed="surfaces that touch or have a gap" + ("" if treated else ", unless the contact gives a treatment"),
        hint=hint,
    )


def refuse_held_slave(slave: Surface, immobile: Flags, name: str, where: Where) -> None:
    """Raise SceneError if no node of the slave can move."""
    if immobile[slave.nodes].all():
        raise SceneError(
            "every node of the slave is held by supports, so its multipliers have nothing to act on",
            where=below(where, "slave"),
            got=name,
            allowed="a slave with nodes that can move",
            hint="exchange the sides: swap = true (or false)",
        )


def _middles(surface: Surface, positions: Floats) -> tuple[Floats, Floats]:
    """Return middle and outward unit normal (s, 2) of every segment."""
    a, b = (positions[surface.nodes[surface.segments[:, i]]] for i in range(2))
    along = b - a
    return 0.5 * (a + b), np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]


def _longest(slave: Surface, master: Surface, positions: Floats) -> float:
    return longest_segment(SurfacePositions(positions[slave.nodes], positions[master.nodes]), slave, master)


def refuse_half_passes(
    spec: Any, enforcement: Enforcement, friction: FrictionLaw | None, rigid: str, where: Where
) -> None:
    """Raise PartError or SceneError for a contact that does not allow two half passes.

    rigid  the name of a side that is rigid, or nothing
    """
    if not isinstance(enforcement, NormalLaw) or enforcement.named():
        use = split_spec("enforcement", spec.enforcement, where)[0] if spec.enforcement else "the integrator's own"
        raise PartError(
            "two half passes press by a law of the gap: multipliers of both sides, or springs of single nodes, would "
            "hold the same gap twice and leave the force on either side undetermined",
            where=below(where, "enforcement"), got=use, allowed=LAWS, hint='write enforcement = "linear-pressure"',
        )  # fmt: skip
    if rigid:
        raise SceneError(
            "two half passes need two sides that deform: a rigid surface has no cells behind it that would press",
            where=below(where, "algorithm"), got=f"passes = 2, with {rigid}", allowed="passes = 1 with a rigid side",
        )  # fmt: skip
    if friction is not None and friction.varies:
        raise PartError(
            "this friction law follows the motion, and friction of half passes uses springs with constant bounds",
            where=below(where, "friction"), got=spec.friction, allowed="a law without needs and memory, as coulomb",
            hint="take passes = 1, or a mortar, for this law",
        )  # fmt: skip
