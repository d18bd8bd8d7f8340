"""Forces at corners of the master, distributed to the slave's nodes at their segments."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, Pieces, Surface
from contactlab.contact.pair import ContactSnapshot, turned
from contactlab.kernels.contact.pair import FAR


def with_shares(slave: Surface, pieces: Pieces, count: int, seen: ContactSnapshot) -> ContactSnapshot:
    """Return the snapshot of a pair of points whose nodes have their shares of forces at corners of the master.

    The algorithm keeps such a force with one of both nodes of the segment that the corner touches.
    """
    at = corner_pieces(pieces, count)
    slot, nodes = pieces.multiplier[at, 0], pieces.slave[at, :2]
    share = pieces.D[at, :2, 0] / pieces.T[at, :1, 0]
    given, gap = np.zeros((2, len(seen.gaps), 2)), np.zeros(len(seen.gaps))
    for part, vectors in enumerate((seen.normals[slot], turned(seen.normals[slot]))):
        np.add.at(given[part], nodes, share[:, :, None] * (seen.forces[part, slot, None] * vectors)[:, None])
    gap[nodes] = seen.gaps[slot, None]
    seen.gaps[slot] = FAR
    for values in (*seen.forces, *seen.tractions, seen.cover, seen.grip):
        values[slot] = 0.0
    add(seen, seen.forces, given, gap)
    nodes = np.unique(nodes)
    cover = np.where(seen.cover[nodes] > 0.0, seen.cover[nodes], _lengths(slave, seen)[nodes])
    seen.tractions[:, nodes] = seen.forces[:, nodes] / cover
    seen.cover[nodes] = seen.grip[nodes] = cover
    return seen


def corner_pieces(pieces: Pieces, count: int) -> Ints:
    """Return the integration segments in use that are corners of the master on segments of the slave."""
    return np.flatnonzero(pieces.segment[:count, 0] < 0).astype(np.int32)


def _lengths(slave: Surface, seen: ContactSnapshot) -> Floats:
    """Return the integrals (m,) [mm] of the shape functions of the slave's nodes."""
    edge = np.bincount(slave.segment_edge[:, 0], slave.lengths(seen.at.slave))
    shares = (0.5, 0.5) if slave.edges.shape[1] == 2 else (1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0)
    found = np.bincount(slave.edges.ravel(), np.outer(edge, shares).ravel(), len(slave.nodes))
    return np.asarray(found, np.float64)


def add(seen: ContactSnapshot, forces: Floats, given: Floats, gap: Floats) -> None:
    """Add normal and tangential forces `given` (2, k, 2) [N] to `forces` (2, k), along normals of their sum.

    `gap` (k,) [mm] replaces gaps without a force.
    """
    normals, gaps = seen.normals, seen.gaps
    nodes = np.flatnonzero(given.any(axis=(0, 2)))
    along = forces[0, nodes, None] * normals[nodes] + given[0, nodes]
    total = along + forces[1, nodes, None] * turned(normals[nodes]) + given[1, nodes]
    gaps[nodes] = np.where((forces[0, nodes] > 0.0) & (gaps[nodes] < FAR), gaps[nodes], gap[nodes])
    normals[nodes] = along / np.hypot(*along.T)[:, None]
    forces[0, nodes] = (total * normals[nodes]).sum(axis=1)
    forces[1, nodes] = (total * turned(normals[nodes])).sum(axis=1)
