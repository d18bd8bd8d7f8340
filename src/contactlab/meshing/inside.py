"""Depth of points inside a closed boundary, in time and memory that grow with their number alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from contactlab.api import Floats, Ints

TOGETHER = 1 << 16  # pairs of a point and an edge that are looked at together: some megabytes


def depths_inside(points: Floats, positions: Floats, edges: Ints) -> Floats:
    """Distance (p,) [mm] from points inside a closed boundary (e, 2) to it; 0 outside."""
    out = np.zeros(len(points))
    inside = np.flatnonzero(windings(points, positions, edges))
    if len(inside):
        out[inside] = distances_to_edges(points[inside], positions[edges[:, 0]], positions[edges[:, 1]])
    return out


def windings(points: Floats, positions: Floats, edges: Ints) -> Floats:
    """Winding numbers of the boundary around points (p,), its inside on the left; 0 outside.

    A ray from the point meets the edges that begin on one side of it and end on the other (the crossing rule with
    signs, Sunday 2001).
    """
    out = np.zeros(len(points))
    corners = positions[edges]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    near = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
    if not len(near):
        return out
    across = int(np.argmax(np.ptp(points[near], axis=0)))
    order = [1 - across, across]  # rays along the first
    found, a, b = points[near][:, order], corners[:, 0, order], corners[:, 1, order]
    for point, edge in _crossed(found[:, 1], a[:, 1], b[:, 1]):
        to_a, to_b = a[edge] - found[point], b[edge] - found[point]
        left = to_a[:, 0] * to_b[:, 1] - to_a[:, 1] * to_b[:, 0] > 0.0
        turns = np.where(to_b[:, 1] > 0.0, left, -1.0 * ~left)
        out[near] += np.bincount(point, turns, len(near))
    return out if across else -out  # axes that change places turn all the other way round


def _crossed(at: Floats, begin: Floats, end: Floats) -> Iterator[tuple[Any, Any]]:
    """Pairs of a point `at` (p,) and an edge (e,) that begins on one side of it and ends on the other.

    All pairs are looked at where they are few, else points and edges are sorted into bins, and only edges of its bin
    are looked at for a point.
    """
    if len(at) * len(begin) <= TOGETHER:
        point, edge = np.nonzero((begin <= at[:, None]) != (end <= at[:, None]))
        yield point, edge
        return
    for point, edge in _pairs(at, np.minimum(begin, end), np.maximum(begin, end)):
        crosses = (begin[edge] <= at[point]) != (end[edge] <= at[point])
        yield point[crosses], edge[crosses]


def _pairs(at: Floats, low: Floats, high: Floats) -> Iterator[tuple[Any, Any]]:
    """Pairs of a point `at` (p,) and an interval (e,); all in which the point lies in the interval are among them."""
    begin, end = float(low.min()), float(high.max())
    count = len(low)
    width = max((end - begin) / count, 1e-300)
    first, last = (np.clip(((x - begin) / width).astype(np.int64), 0, count - 1) for x in (low, high))
    spread = last - first + 1
    of_bin = np.repeat(first - np.concatenate([[0], np.cumsum(spread)[:-1]]), spread) + np.arange(int(spread.sum()))
    order = np.argsort(of_bin, kind="stable")
    edges = np.repeat(np.arange(count), spread)[order]
    start = np.searchsorted(of_bin[order], np.arange(count + 1))
    near = np.flatnonzero((at >= begin) & (at <= end))
    bins = np.clip(((at[near] - begin) / width).astype(np.int64), 0, count - 1)
    many = start[bins + 1] - start[bins]
    upto = np.cumsum(many)
    done = 0
    while done < len(near):
        stop = max(done + 1, int(np.searchsorted(upto, (upto[done - 1] if done else 0) + TOGETHER, side="right")))
        some, sizes = bins[done:stop], many[done:stop]
        skip = np.repeat(start[some] - np.concatenate([[0], np.cumsum(sizes)[:-1]]), sizes)
        yield np.repeat(near[done:stop], sizes), edges[skip + np.arange(int(sizes.sum()))]
        done = stop


def distances_to_edges(points: Floats, a: Floats, b: Floats) -> Floats:
    """Distance of each point to the nearest of the edges from a to b (e, 2).

    Edges are looked at by their lengths, each kind at most twice as long as its shortest: a long one would make all
    short ones near it candidates. The longest come first: how near they are bounds where shorter ones are looked for.
    """
    if len(points) * len(a) <= TOGETHER:
        return np.array([_distance(point, a, b).min() for point in points])
    from scipy.spatial import KDTree

    length = np.hypot(*(b - a).T)
    kind = np.floor(np.log2(np.maximum(length, 1e-300))).astype(np.int64)
    least = np.array(KDTree(a).query(points)[0])
    for longest in np.unique(kind)[::-1]:
        own = np.flatnonzero(kind == longest)
        reach = (least + 0.5 * length[own].max()) * (1.0 + 1e-9)
        near = KDTree(0.5 * (a[own] + b[own])).query_ball_point(points, reach)
        point = np.repeat(np.arange(len(points)), [len(found) for found in near])
        edge = own[np.concatenate(near).astype(np.int64)]
        np.minimum.at(least, point, _distance(points[point], a[edge], b[edge]))
    return least


def _distance(point: Floats, a: Floats, b: Floats) -> Floats:
    """Distance (e,) of a point (2,), or of a point for each (e, 2), to edges from a to b (e, 2)."""
    along, to_a = b - a, a - point
    share = np.clip(-np.einsum("ei,ei->e", to_a, along) / np.einsum("ei,ei->e", along, along), 0.0, 1.0)
    return np.asarray(np.hypot(*(to_a + share[:, None] * along).T))
