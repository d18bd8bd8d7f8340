"""Meshes: moving them, checking them, and cutting surfaces out of them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.element import Element
from contactlab.api.mesh import Mesh
from contactlab.api.surface import Surface
from contactlab.meshing.turns import facet_lengths, turns

SHARP = math.radians(60.0)  # turn of any node that is a corner
KINK = 0.3  # rad: so much turns a corner that no curve passes; one normal for both flanks errs by 1 % of the pressure


def moved(mesh: Mesh, rotate: float, shift: tuple[float, float]) -> Mesh:
    """The mesh turned by `rotate` degrees about the origin, then shifted [mm]."""
    nodes = mesh.nodes
    if rotate != 0.0:
        angle = math.radians(rotate)
        cos, sin = math.cos(angle), math.sin(angle)
        nodes = nodes @ np.array([[cos, sin], [-sin, cos]])
    if shift[0] != 0.0 or shift[1] != 0.0:
        nodes = nodes + np.asarray(shift)
    return replace(mesh, nodes=np.ascontiguousarray(nodes))


def jacobians(mesh: Mesh, element: Element, points: Floats) -> Floats:
    """Jacobian determinants (n, s) of the cells' maps at reference `points` (s, 2)."""
    derivatives = element.shape(points).gradient
    x = mesh.nodes[mesh.cells]
    j = np.einsum("saj,nai->nsij", derivatives, x)
    return np.asarray(j[..., 0, 0] * j[..., 1, 1] - j[..., 0, 1] * j[..., 1, 0])


def inverted_cells(mesh: Mesh, element: Element) -> Ints:
    """Cells whose map folds over at a node or at a quadrature point."""
    points = np.concatenate([element.nodes, element.quadrature().points])
    return np.flatnonzero((jacobians(mesh, element, points) <= 0.0).any(axis=1)).astype(np.int32)


def nodal_measure(mesh: Mesh, element: Element) -> Floats:
    """Area (N,) [mm2] that each node's lumped mass stands for, by the element's `lumping`."""
    area = np.zeros(len(mesh.nodes))
    np.add.at(area, mesh.cells, cell_measures(mesh, element))
    return area


def cell_measures(mesh: Mesh, element: Element) -> Floats:
    """Area (n, a) [mm2] that each cell gives to the lumped mass of its nodes."""
    return _quadrature_areas(mesh, element) if element.lumping == "quadrature" else _shape_areas(mesh, element)


def _shape_areas(mesh: Mesh, element: Element) -> Floats:
    rule = element.quadrature()
    shape = element.shape(rule.points).value
    weight = jacobians(mesh, element, rule.points) * rule.weights
    if element.lumping == "row-sum":
        return np.asarray(weight @ shape)
    diagonal = weight @ shape**2
    return np.asarray(diagonal * (weight.sum(axis=1) / diagonal.sum(axis=1))[:, None])


def _quadrature_areas(mesh: Mesh, element: Element) -> Floats:
    """Nodal quadrature with the Lobatto weights 1/3, 4/3, 1/3 (or 1, 1) per direction."""
    order = 1 if np.all(np.abs(element.nodes) == 1.0) else 2
    one = np.where(np.abs(element.nodes) < 0.5, 4.0 / 3.0, 1.0 / 3.0) if order == 2 else np.ones_like(element.nodes)
    return np.asarray(jacobians(mesh, element, element.nodes) * one.prod(axis=1))


def outer_edges(cells: Ints, element: Element) -> Ints:
    """Straight segments (e, 2) of the sides that belong to one of the `cells` (n, a) only, the body on their left."""
    return segments_of(outer_sides(cells, element)[0])


def outer_sides(cells: Ints, element: Element) -> tuple[Ints, Ints]:
    """Sides (s, b) that belong to one of the `cells` (n, a) only: start, end, inner nodes; and the cell of each."""
    sides = np.concatenate([cells[:, list(edge)] for edge in element.edges])
    low, high = np.sort(sides[:, :2].astype(np.int64), axis=1).T
    _, number, count = np.unique(low * (high.max(initial=0) + 1) + high, return_inverse=True, return_counts=True)
    outer = np.flatnonzero(count[number.ravel()] == 1)
    return sides[outer], (outer % len(cells)).astype(np.int32)


def segments_of(sides: Ints) -> Ints:
    """Straight segments (e, 2) between neighbouring nodes of sides (s, b): start, end, inner nodes."""
    path = [0, *range(2, sides.shape[1]), 1]
    return np.concatenate([sides[:, [a, b]] for a, b in pairwise(path)])


def surface_from_edges(edges: Ints) -> Surface:
    """The contact surface made of `edges` (e, b): start, end, then inner nodes; the body on the left.

    Edges may come in any order and form several chains, open or closed. Raises ValueError if an
    edge set branches.
    """
    order = _chain_order(edges)
    nodes: list[int] = []
    position: dict[int, int] = {}
    segments, segment_edge, local = [], [], []
    for number, e in enumerate(order):
        start, end, *inner = (int(node) for node in edges[e])
        path = [start, *inner, end]
        for node in path:
            if node not in position:
                position[node] = len(nodes)
                nodes.append(node)
        for half in range(len(path) - 1):
            segments.append((position[path[half]], position[path[half + 1]]))
            segment_edge.append((number, half))
        local.append([position[node] for node in (start, end, *inner)])
    joined = np.array(segments, np.int32).reshape(-1, 2)
    return Surface(
        np.array(nodes, np.int32),
        joined,
        _neighbours(len(nodes), joined),
        np.array(local, np.int32).reshape(-1, edges.shape[1]),
        np.array(segment_edge, np.int32).reshape(-1, 2),
    )


def corners(surface: Surface, positions: Floats, least: float | None) -> np.ndarray:
    """Nodes of a surface that are corners: they turn by more than `least` degrees.

    Without `least`: by more than `SHARP`, or by more than `KINK` where no curve passes.
    """
    angle = np.abs(turns(surface, positions))
    if least is not None:
        return np.flatnonzero(angle > math.radians(least))
    alone = ~np.isfinite(facet_lengths(surface, positions))
    return np.flatnonzero((angle > SHARP) | ((angle > KINK) & alone))


def split_at_corners(surface: Surface, positions: Floats, least: float | None = None) -> Surface:
    """The surface cut at its `corners`: the node there ends one chain and begins the next.

    positions  (N, 2) [mm] of all nodes. Such a node counts once for each flank, with the normal of that flank:
    an average of both belongs to neither.
    """
    sharp = corners(surface, positions, least)
    if not len(sharp):
        return surface
    out = surface.node_segments[:, 1]
    copy = {int(node): len(surface.nodes) + i for i, node in enumerate(sharp)}
    segments, edges = surface.segments.copy(), surface.edges.copy()
    for node, second in copy.items():
        # the second flank begins with the copy
        segments[out[node], 0] = second
        edge = edges[surface.segment_edge[out[node], 0]]
        edge[edge == node] = second
    nodes = np.concatenate([surface.nodes, surface.nodes[sharp]])
    return _in_chain_order(Surface(nodes, segments, _neighbours(len(nodes), segments), edges, surface.segment_edge))


def _in_chain_order(surface: Surface) -> Surface:
    """The same surface with its nodes numbered along each chain."""
    order: list[int] = []
    seen: set[int] = set()
    for segment in surface.segments.tolist():
        order += [node for node in segment if node not in seen]
        seen.update(segment)
    place = np.argsort(np.array(order)).astype(np.int32)
    segments = place[surface.segments]
    return Surface(
        surface.nodes[order], segments, _neighbours(len(order), segments), place[surface.edges], surface.segment_edge
    )


def _neighbours(nodes: int, segments: Ints) -> Ints:
    """Segment that ends and segment that starts at each node (m, 2), -1 for none."""
    found = np.full((nodes, 2), -1, np.int32)
    found[segments[:, 0], 1] = np.arange(len(segments))
    found[segments[:, 1], 0] = np.arange(len(segments))
    return found


def _chain_order(edges: Ints) -> list[int]:
    """Edge numbers in chain order: open chains from their free start, then closed ones."""
    starts = {int(edge[0]): e for e, edge in enumerate(edges)}
    ends = {int(edge[1]): e for e, edge in enumerate(edges)}
    if len(starts) != len(edges) or len(ends) != len(edges):
        raise ValueError("the edges branch: some node starts or ends two of them")
    order: list[int] = []
    done: set[int] = set()
    heads = [e for e, edge in enumerate(edges) if int(edge[0]) not in ends]
    for head in [*heads, *range(len(edges))]:
        e: int | None = head
        while e is not None and e not in done:
            done.add(e)
            order.append(e)
            e = starts.get(int(edges[e, 1]))
    return order
