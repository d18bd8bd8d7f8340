"""Curves through the nodes of a surface, which its facets follow: how far both lie apart, and points off a curve."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.meshing.turns import facet_lengths, turns

CORNER = 0.6
"""Angle [rad] between segments above which a node is a corner, and no part of a curve."""

PAIRS = 250_000  # of points and segments that are compared at a time


def facet_depths(surface: Surface, reference: Floats) -> Floats:
    """Distance (m,) [mm] of a smooth curve from its facets at each node that turns: length times angle over 8.

    A node belongs to a curve if the surface turns by a like angle at a node near by; the facet is what lies between.
    """
    angle, length = np.abs(turns(surface, reference)), facet_lengths(surface, reference)
    return np.asarray(np.where((angle < CORNER) & np.isfinite(length), angle * np.nan_to_num(length) / 8.0, 0.0))


def distances_to_curve(points: Floats, surface: Surface, position: Floats, reference: Floats) -> Floats:
    """Distances (n,) [mm] of points (n, 2) to the curve through the nodes of a surface, negative inside.

    Beyond the end of a chain they are measured along the normal of its last segment, as there is no surface.

    position   (N, 2) [mm] of the model's nodes; reference: undeformed, which distinguishes facets from kinks
    """
    depths = facet_depths(surface, reference) * np.sign(turns(surface, reference))
    return _in_parts(points, surface, position, depths)


def distances_to_facets(points: Floats, surface: Surface, position: Floats) -> Floats:
    """Distances (n,) [mm] of points (n, 2) to the segments of a surface; otherwise as `distances_to_curve`."""
    return _in_parts(points, surface, position, np.zeros(len(surface.nodes)))


def _in_parts(points: Floats, surface: Surface, position: Floats, depths: Floats) -> Floats:
    size = max(1, PAIRS // len(surface.segments))
    parts = (points[first : first + size] for first in range(0, len(points), size))
    return np.concatenate([np.zeros(0), *(_distances(part, surface, position, depths) for part in parts)])


def nearest_segments(points: Floats, surface: Surface, position: Floats) -> tuple[Ints, Floats]:
    """Segments (n,) of a surface nearest to points (n, 2), and the projections (n,) of the points on their lines.

    0 is the start of a segment and 1 its end; `position` (N, 2) [mm] of the model's nodes.
    """
    begin, end = (position[surface.nodes[surface.segments[:, k]]] for k in range(2))
    along, apart = end - begin, points[:, None] - begin
    at = (apart * along).sum(axis=2) / (along**2).sum(axis=1)
    apart = apart - np.clip(at, 0.0, 1.0)[..., None] * along
    nearest = (apart**2).sum(axis=2).argmin(axis=1)
    return nearest.astype(np.int32), at[np.arange(len(points)), nearest]


def _distances(points: Floats, surface: Surface, position: Floats, depths: Floats) -> Floats:
    nearest, at = nearest_segments(points, surface, position)
    begin, end = (position[surface.nodes[surface.segments[nearest, k]]] for k in range(2))
    # chain ends at the start, at the end of a segment
    last = surface.node_segments[surface.segments, [0, 1]] < 0
    beyond = ((at < 0.0) & last[nearest, 0]) | ((at > 1.0) & last[nearest, 1])
    at = np.clip(at, 0.0, 1.0)
    edge = end - begin
    off = (points - begin) - at[:, None] * edge
    height = (off[:, 0] * edge[:, 1] - off[:, 1] * edge[:, 0]) / np.hypot(*edge.T)
    both = depths[surface.segments]
    both = np.where(last, both[:, ::-1], both)  # an end has no turn of its own
    bulge = 4.0 * at * (1.0 - at) * both.mean(axis=1)[nearest]
    return np.asarray(np.where(beyond, height, np.copysign(np.hypot(*off.T), height)) - bulge)
