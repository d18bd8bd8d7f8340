"""Pieces of a mortar contact as dense matrices, and the surfaces that their tests are about."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ContactView, Floats, PieceDerivatives, Pieces
from contactlab.api.surface import SurfacePositions
from contactlab.kernels.contact.search import near_segments
from contactlab.testing.surfaces import Chains, chains, curved, flat, stations

H = 1e-6  # of central differences over surfaces of size one: their error and round-off over H are below 1e-9
AGREED = 2e-9


def rough(at: Chains, by: float = 0.01) -> Chains:
    """The same surfaces with every node off by some hundredths of a segment: no symmetry, no plane left."""
    return at.moved(at.nodes + np.random.default_rng(7).normal(scale=by, size=at.nodes.shape))


def fold() -> Chains:
    """A slave with a vertex whose flanks turn by 0.4 rad: its normal is neither the averaged one nor the master's."""
    points = np.array([[-0.9, 0.02], [-0.4, 0.0], [0.0, 0.01], [0.5, 0.21], [1.0, 0.42]])
    return chains(points, np.array([[-1.2, -0.02], [-0.25, 0.01], [0.6, -0.01], [1.4, 0.0]]))


def shallow() -> Chains:
    """Arcs that lean against each other by less than makes the ends of a chain vertices."""
    s, m = stations(-0.8, 0.8, 7, seed=3), stations(-1.0, 1.0, 6, seed=4)
    return chains(np.stack([s, 0.1 * s**2], axis=1), np.stack([m, 0.02 * m**2], axis=1))


def steep() -> Chains:
    """A slave over a flank of its master that falls by 76 degrees: it counts in part."""
    return chains(
        np.array([[-0.6, 0.1], [-0.4, 0.1], [-0.2, 0.1], [0.0, 0.1], [0.15, 0.1], [0.3, 0.1], [0.6, 0.1]]),
        np.array([[-0.8, 0.0], [-0.3, 0.01], [0.1, 0.0], [0.25, -0.6]]),
    )


SURFACES = {
    "steep": rough(steep(), 0.003),
    "shallow": rough(shallow(), 0.003),
    "curved": rough(curved()),
    "partly covered": rough(flat(full=False)),
    "quadratic": rough(flat(full=False, order=2), 0.003),
}


def view_of(at: Chains, nodes: Floats | None = None, *, ends: bool = True) -> ContactView:
    """What an algorithm sees of surfaces, with all segments near each other; `nodes` (N, 2) are where they are now.

    Without `ends` nothing is near the edges at the ends of the slave, whose normals would be the master's.
    """
    x = at.nodes if nodes is None else nodes
    sides = SurfacePositions(np.ascontiguousarray(x[at.slave.nodes]), np.ascontiguousarray(x[at.master.nodes]))
    near = near_segments(sides.slave, at.slave.segments, sides.master, at.master.segments, 100.0)
    if not ends:
        per_edge = at.slave.edges.shape[1] - 1
        near = near._replace(start=np.clip(near.start, near.start[per_edge], near.start[-1 - per_edge]))
    return ContactView(at.slave, at.master, sides, near, 100.0, np.zeros((1, len(at.slave.nodes))))


def pieces_of(algorithm: Any, view: ContactView) -> tuple[Pieces, int]:
    """Pieces and their number."""
    capacity = algorithm.capacity(view.slave, view.near)
    slots = algorithm.rows_per_node * len(view.slave.nodes)
    out = Pieces.allocate(capacity, algorithm.widths(view.slave, view.master), slots)
    return out, algorithm.pieces(view, out)


def summed(pieces: Pieces, count: int, view: ContactView) -> tuple[Floats, Floats, Floats]:
    """D (m, k), M (l, k) and T (k, k) of the pieces."""
    m, r, k = len(view.slave.nodes), len(view.master.nodes), len(pieces.normal)
    D, M, T = np.zeros((m, k)), np.zeros((r, k)), np.zeros((k, k))
    p, j = pieces, pieces.multiplier[:count, None, :]
    np.add.at(D, (p.slave[:count, :, None], j), p.D[:count])
    np.add.at(M, (p.master[:count, :, None], j), p.M[:count])
    np.add.at(T, (p.multiplier[:count, :, None], j), p.T[:count])
    return D, M, T


def derivatives_of(algorithm: Any, at: Chains) -> tuple[PieceDerivatives, Pieces, int, ContactView]:
    """What the algorithm gives as derivatives of its pieces."""
    view = view_of(at)
    pieces, count = pieces_of(algorithm, view)
    out = PieceDerivatives.allocate(
        32 * count, algorithm.widths(at.slave, at.master), 40 * len(at.slave.nodes) + 32 * count
    )
    assert algorithm.derivatives(view, pieces, count, out)
    return out, pieces, count, view


def along(view: ContactView, at: Chains, moved: Floats, move: Floats) -> Floats:
    """Components of a move (N, 2) of all nodes along moved coordinates: slave nodes first, then the master's."""
    both = np.concatenate([move[at.slave.nodes], move[at.master.nodes]])
    return np.asarray(both[moved // 2, moved % 2])


def central(algorithm: Any, at: Chains, move: Floats, *, ends: bool = True) -> tuple[Floats, ...]:
    """Central differences of D, M, T and the normals along a move (N, 2) of all nodes."""
    found = []
    for step in (H, -H):
        view = view_of(at, at.nodes + step * move, ends=ends)
        pieces, count = pieces_of(algorithm, view)
        found.append((*summed(pieces, count, view), pieces.normal.copy()))
    return tuple((high - low) / (2.0 * H) for high, low in zip(*found, strict=True))


def drawn_move(at: Chains) -> Floats:
    """Any move of all nodes."""
    return np.random.default_rng(3).normal(size=at.nodes.shape)
