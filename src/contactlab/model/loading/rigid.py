"""Rigid surfaces: chains of nodes without mass whose motion is prescribed."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.contact.closest import crossing
from contactlab.errors import SceneError, Where
from contactlab.model.bodies.body import Body, RigidSurface
from contactlab.model.loading.edge_sets import edge_set
from contactlab.model.sizes import check_rigid_size
from contactlab.scene.keys import Arc, Rigid
from contactlab.scene.scene import Scene

SAGITTA = 1e-3  # of its radius: largest height of an arc above its segments


def build_rigid(scene: Scene, bodies: tuple[Body, ...]) -> tuple[RigidSurface, ...]:
    """Return all rigid surfaces of the scene, numbered after the nodes of the bodies."""
    first = sum(body.count for body in bodies)
    surfaces: list[RigidSurface] = []
    for name, spec in scene.rigid.items():
        facing = _facing(scene, bodies, name)
        longest = max((_longest(edges, bodies) for edges in facing), default=math.inf)
        segment = spec.segment if spec.segment is not None else longest
        width = facing[0].shape[1] if facing else 2
        where = scene.where(f"rigid.{name}" + (".segment" if spec.segment is not None else ""))
        check_rigid_size(_length(spec) / segment, where, segment)
        if spec.line is not None:
            _refuse_crossing(np.array(spec.line), scene.where(f"rigid.{name}.line"))
        points, closed = _chain(spec, segment, width - 1)
        surfaces.append(RigidSurface(name, points, first, _edges(first, len(points), closed, width)))
        first += len(points)
    return tuple(surfaces)


def _refuse_crossing(points: Floats, where: Where) -> None:
    """Raise SceneError for a polyline that intersects itself, where no side of it is solid."""
    segments = np.stack([np.arange(len(points) - 1), np.arange(1, len(points))], axis=1).astype(np.int32)
    place = crossing(points, segments, segments)
    if place is not None:
        raise SceneError(
            "a rigid surface goes through itself",
            where=where,
            got=f"segments that cross at ({place[0]:.6g}, {place[1]:.6g})",
            allowed="a line with its solid on one side",
        )


def _facing(scene: Scene, bodies: tuple[Body, ...], name: str) -> list[Ints]:
    """Return edge sets that have this surface as their master."""
    found = []
    for number, contact in enumerate(scene.contacts):
        slaves, masters = contact.targets
        if name in masters:
            where = scene.where(f"contacts.{number}.slave")
            found += [edge_set(bodies, slave, where)[1] for slave in slaves]
    return found


def _longest(edges: Ints, bodies: tuple[Body, ...]) -> float:
    """Return the longest segment [mm] of an edge set; a quadratic edge is two segments."""
    nodes = np.concatenate([body.mesh.nodes for body in bodies])
    chord = nodes[edges[:, 1]] - nodes[edges[:, 0]]
    return float(np.hypot(chord[:, 0], chord[:, 1]).max() / (edges.shape[1] - 1))


def _length(spec: Rigid) -> float:
    """Return the length of a rigid surface [mm]."""
    if spec.arc is not None:
        return float(abs(np.subtract(*np.radians(spec.arc.angles))) * spec.arc.radius)
    return float(np.hypot(*np.diff(np.array(spec.line), axis=0).T).sum())


def _chain(spec: Rigid, segment: float, multiple: int) -> tuple[Floats, bool]:
    """Return points along the surface and whether they close; segments come in multiples of `multiple` per piece."""
    if spec.arc is not None:
        return _arc(spec.arc, segment, multiple)
    corners = np.array(spec.line)
    closed = bool(np.array_equal(corners[0], corners[-1])) and len(corners) > 2
    pieces = [corners[:1]]
    for a, b in pairwise(corners):
        count = multiple * max(1, math.ceil(float(np.hypot(*(b - a))) / (multiple * segment) * (1.0 - 1e-9)))
        pieces.append(a + (b - a) * (np.arange(1, count + 1) / count)[:, None])
    points = np.concatenate(pieces)
    return (points[:-1] if closed else points), closed


def _arc(arc: Arc, segment: float, multiple: int) -> tuple[Floats, bool]:
    first, last = np.radians(arc.angles)
    turn = abs(last - first)
    closed = math.isclose(turn, 2.0 * math.pi)
    # a chord of angle t lies r (1 - cos(t/2)) below the arc
    widest = min(segment / arc.radius, 2.0 * math.acos(1.0 - SAGITTA))
    count = multiple * max(3 if closed else 1, math.ceil(turn / (multiple * widest) * (1.0 - 1e-9)))
    angle = first + (last - first) * np.arange(count + (not closed)) / count
    return np.asarray(arc.centre) + arc.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), closed


def _edges(first: int, count: int, closed: bool, width: int) -> Ints:
    """Return edges (e, width): start, end, then the inner node of quadratic ones."""
    step = width - 1
    start = first + np.arange(0, count if closed else count - 1, step)
    end = first + (start - first + step) % count
    inner = [start + i for i in range(1, step)]
    return np.stack([start, end, *inner], axis=1).astype(np.int32)
