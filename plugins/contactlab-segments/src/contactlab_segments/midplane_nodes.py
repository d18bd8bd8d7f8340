"""Mapping from the nodes of two surfaces to the vertices that press on each other, and back."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, kron

from contactlab.api import Floats, Ints, PotentialView
from contactlab_segments.midplane_kernels import meeting, press

DEEPEST = 2.0  # of the longest segment: deeper overlaps are the far side of a thin body
EDGE = 0.1  # of its neighbour's force: what a node beyond the edge of contact may bear for itself


def polygon(view: PotentialView) -> Any:
    """Vertices (n, n) by nodes: quadratic edges count as two segments that enclose the same area, by Simpson's rule.

    Equal areas make a uniform pressure on the segments the consistent forces 1/6, 4/6, 1/6 on the nodes of the edge.
    """
    n = len(view.reference)
    found = eye_array(n, format="csr")
    for edges in (view.slave.edges, view.master.edges + len(view.slave.nodes)):
        if edges.shape[1] == 3:
            place = np.repeat(edges[:, 2], 3), edges.ravel()
            found = found + csr_array((np.tile([-1 / 6, -1 / 6, 1 / 3], len(edges)), place), shape=(n, n))
    return found


class Overlaps(NamedTuple):
    """Pairs of segments that meet, and what kernels need of them.

    at         (n, 2) [mm] vertices of the polygons
    pairs      (c, 6) numbers of both segments, and the nodes of the four ends
    length     (e,) [mm] undeformed, and `ends` (n,) whether a chain ends at a node
    stiffness  [MPa/mm] pressure per overlap
    deepest    [mm] deeper overlaps are the far side of a thin body
    """

    at: Floats
    pairs: Ints
    length: Floats
    ends: Any
    stiffness: float
    deepest: float

    def derivative(self) -> Floats:
        """Derivative of the energy by the vertices (n, 2) [N]."""
        found = np.zeros_like(self.at)
        press(*self, found)
        return found


def overlaps(view: PotentialView, positions: Floats, stiffness: float) -> Overlaps:
    """Find the pairs of segments that touch or overlap."""
    vertices, of = polygon(view), np.concatenate([view.slave.nodes, view.master.nodes])
    length = np.hypot(*np.diff((vertices @ view.reference)[view.edges], axis=1)[:, 0].T)
    ends = np.bincount(of[view.edges].ravel(), minlength=of.max() + 1)[of] == 1
    given = length, ends, stiffness, DEEPEST * float(length.max())
    at, pairs, count = vertices @ positions, np.zeros((0, 6), np.int32), len(view.edges)
    while count > len(pairs):
        pairs = np.zeros((count, 6), np.int32)
        count = meeting(at, view.edges, len(view.slave.segments), *given, pairs)
    return Overlaps(at, pairs[:count], *given)


def assembled(view: PotentialView, nodes: Ints, block: Floats) -> Any:
    """Matrix (2n, 2n) of the nodes from blocks (c, 8, 8) of four vertices (c, 4) each."""
    size = 2 * len(view.reference)
    dof = (2 * nodes[:, :, None] + np.arange(2)).reshape(-1, 8)
    place = np.repeat(dof, 8, axis=1).ravel(), np.tile(dof, 8).ravel()
    by_node = kron(polygon(view), eye_array(2), "csr")
    return by_node.T @ coo_array((block.ravel(), place), shape=(size, size)).tocsr() @ by_node


def gathered(view: PotentialView, forces: Floats) -> Floats:
    """Forces (2, m, 2) on the slave's nodes, of pressure and of friction: small ones beyond the edge of contact moved.

    They are their neighbour's. Their hats reach into the last segment that presses. Mortars, too, merge multipliers
    with little cover.
    """
    segments, found = view.slave.segments, forces.copy()
    here, there = np.concatenate([segments, segments[:, ::-1]]).T
    load = np.hypot(*forces[0].T)
    bare = np.zeros(len(load), np.bool_)
    bare[here[load[there] <= 0.0]] = True
    small = bare[here] & (load[here] > 0.0) & (load[here] < EDGE * load[there])
    for all_of, given in zip(found, forces, strict=True):
        np.add.at(all_of, there[small], given[here[small]])
    found[:, here[small]] = 0.0
    return found
