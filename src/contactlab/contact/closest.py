"""Closest points of two surfaces in plain NumPy, and intersections of their segments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from contactlab.api import Candidates, ContactView, Floats, GapAlgorithm, GapConditions, Ints, Surface
from contactlab.kernels.contact.search import near_segments

STRAIGHT = 0.999  # cosine to the normal of a chain's last segment: nodes beyond its end are not behind it


class Feet(NamedTuple):
    """Points of one surface projected onto segments of another, one row for each of p pairs.

    node, segment  (p,) positions in the first surface, and in the segments of the second
    share          (p,) of the segment, 0 to 1, at the closest point
    apart          (p, 2) [mm] from the closest point to the node
    distance       (p,) [mm] negative for a node behind the inside of the segment
    direction      (p, 2) unit vectors from the segment to the node
    """

    node: Ints
    segment: Ints
    share: Floats
    apart: Floats
    distance: Floats
    direction: Floats


def closest_points(x: Floats, own: Surface, y: Floats, other: Surface, near: Candidates) -> Feet:
    """Return the projection of every node (positions x) of the segments in `near` on its candidates (positions y)."""
    count = np.diff(near.start)
    node = np.repeat(own.segments, count, axis=0).T.ravel()
    segment = np.tile(near.master, 2)
    a, along = y[other.segments[segment, 0]], y[other.segments[segment, 1]] - y[other.segments[segment, 0]]
    length = np.hypot(*along.T)
    share = np.clip(((x[node] - a) * along).sum(axis=1) / length**2, 0.0, 1.0)
    apart = x[node] - a - share[:, None] * along
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    height, distance = (apart * normal).sum(axis=1), np.hypot(*apart.T)
    vertex = other.segments[segment, (share == 1.0).astype(int)]
    at_end = (share <= 0.0) | (share >= 1.0)
    # side of a vertex: by the normals of both its segments; at the end of a chain by the last one, if straight behind
    both = (other.node_segments[vertex] >= 0).all(axis=1)
    behind = np.where(
        both, (apart * _vertex_normals(y, other)[vertex]).sum(axis=1) < 0.0, height < -STRAIGHT * distance
    )
    signed = np.where(at_end, np.where(behind, -distance, distance), height)
    away = at_end & (distance > 0.0)
    direction = np.where(away[:, None], apart / np.where(away, signed, 1.0)[:, None], normal)
    return Feet(node, segment, share, apart, signed, direction)


def _vertex_normals(y: Floats, surface: Surface) -> Floats:
    """Return sums (m, 2) of the outward unit normals of the segments at each node."""
    along = y[surface.segments[:, 1]] - y[surface.segments[:, 0]]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    out = np.zeros_like(y)
    for end in range(2):
        np.add.at(out, surface.segments[:, end], normal)
    return out


def first_crossing(at: Floats, one: Surface, other: Surface) -> Floats | None:
    """Return an intersection point (2,) of two surfaces at positions (N, 2) of all nodes; None without one.

    Segments are compared, so corners between two nodes of the other side count.
    """
    return crossing(at, one.nodes[one.segments], other.nodes[other.segments])


def crossing(at: Floats, segments: Ints, others: Ints) -> Floats | None:
    """Return a point (2,) at which one of the segments (s, 2) and one of the others cross; None without one."""
    (a, b), (c, d) = (at[ends].swapaxes(0, 1) for ends in close_pairs(at, segments, others))
    sides = [cross(b - a, c - a), cross(b - a, d - a), cross(d - c, a - c), cross(d - c, b - c)]
    crossed = np.flatnonzero((sides[0] * sides[1] < 0.0) & (sides[2] * sides[3] < 0.0))
    if not len(crossed):
        return None
    k = crossed[0]
    share = sides[2][k] / (sides[2][k] - sides[3][k])
    return np.asarray(a[k] + share * (b[k] - a[k]))


def close_pairs(at: Floats, segments: Ints, others: Ints) -> tuple[Ints, Ints]:
    """Return segments and others (k, 2), one of each in a row, with intersecting boxes at positions (N, 2)."""
    near = near_segments(at, segments, at, others, 0.0)
    return np.repeat(segments, np.diff(near.start), axis=0), others[near.master]


def cross(u: Floats, v: Floats) -> Floats:
    """Return the out-of-plane component (k,) of the cross products of vectors (k, 2)."""
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


@dataclass(frozen=True)
class ClosestPoints(GapAlgorithm):
    """Distances of slave nodes from the closest points of the master: a measure of contact without constraints."""

    passes_patch_test: ClassVar[bool] = False

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        """Return a constraint for each node within the search distance of a segment, unless far behind it."""
        found = closest_points(view.at.slave, view.slave, view.at.master, view.master, view.near)
        order = np.lexsort((found.segment, np.abs(found.distance), found.node))
        order = order[np.abs(found.distance[order]) <= view.reach]
        owner, first = np.unique(found.node[order], return_index=True)
        chosen = order[first]
        k, share, direction = len(chosen), found.share[chosen], found.direction[chosen]
        ends = view.master.segments[found.segment[chosen]]
        node = np.column_stack([view.slave.nodes[owner], view.master.nodes[ends]]).astype(np.int32)
        shares = np.column_stack([np.ones(k), share - 1.0, -share])
        weight = (shares[:, :, None] * direction[:, None, :]).reshape(-1, 2)
        across = np.stack([weight[:, 1], -weight[:, 0]], axis=1) if tangent else np.zeros((0, 2))
        measure = np.zeros(len(view.at.slave))
        np.add.at(measure, view.slave.segments, 0.5 * view.slave.lengths(view.at.slave)[:, None])
        start = np.arange(0, 3 * k + 1, 3, dtype=np.int32)
        return GapConditions(
            start, node.ravel(), weight, across, found.distance[chosen], measure[owner], owner.astype(np.int32)
        )
