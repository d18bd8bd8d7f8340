"""Forces at corners of the master, distributed to the slave's nodes at their segments."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.contact.pair import ContactSnapshot, turned
from contactlab.kernels.contact.pair import FAR

if TYPE_CHECKING:
    from contactlab.contact.corner_pair import CornerPair
    from contactlab.contact.operator_pair import OperatorPair

LEAST = 0.5  # of its length: with less overlap a node spreads no corner force


def with_corners(pair: OperatorPair, seen: ContactSnapshot, multipliers: Floats) -> ContactSnapshot:
    """Return the snapshot of a mortar pair with nodal forces that include corner forces.

    The resultant contains all forces. Forces of points, and corner forces that would change the sign of tractions,
    are no tractions of the basis: each node gets its share of them, over its length.
    """
    corners = pair.corners
    assert corners is not None
    forces, grip = corners.at_nodes(seen.forces), corners.at_nodes(seen.grip[None])[0]
    tractions = np.stack([pair.tractions(force) for force in forces])
    pointed = corners.at_nodes(np.zeros_like(forces))
    taken = [k for moved in corners.moved for k in (moved.slot, moved.partner)]
    enough = seen.cover >= LEAST * pair.full
    if len(taken) and (tractions[0, taken].min() < 0.0 or not enough[taken].all()):
        spread = seen.forces.copy()
        spread[:, [moved.slot for moved in corners.moved]] = 0.0
        tractions, pointed = np.stack([pair.tractions(force) for force in spread]), forces - spread
    cover = seen.cover
    given, gap = _of_points(pair, multipliers, len(seen.gaps))
    before = forces.copy()
    _add(seen, forces, given, gap)
    pointed += forces - before
    bears = pointed.any(axis=0)
    tractions[:, bears & ~enough] = 0.0
    pointed[:, bears & ~enough] = forces[:, bears & ~enough]
    cover[bears] = np.where(enough, cover, np.where(cover > 0.0, LEAST, 1.0) * pair.full)[bears]
    tractions[:, bears] += pointed[:, bears] / cover[bears]
    return ContactSnapshot(seen.at, seen.gaps, seen.normals, cover, grip, forces, tractions)


def with_shares(pair: OperatorPair, seen: ContactSnapshot) -> ContactSnapshot:
    """Return the snapshot of a pair of points whose nodes have their shares of forces at corners of the master.

    The algorithm keeps such a force with one of both nodes of the segment that the corner touches.
    """
    at = corner_pieces(pair)
    slot, nodes = pair.pieces.multiplier[at, 0], pair.pieces.slave[at, :2]
    share = pair.pieces.D[at, :2, 0] / pair.pieces.T[at, :1, 0]
    given, gap = np.zeros((2, len(seen.gaps), 2)), np.zeros(len(seen.gaps))
    for part, vectors in enumerate((seen.normals[slot], turned(seen.normals[slot]))):
        np.add.at(given[part], nodes, share[:, :, None] * (seen.forces[part, slot, None] * vectors)[:, None])
    gap[nodes] = seen.gaps[slot, None]
    seen.gaps[slot] = FAR
    for values in (*seen.forces, *seen.tractions, seen.cover, seen.grip):
        values[slot] = 0.0
    _add(seen, seen.forces, given, gap)
    nodes = np.unique(nodes)
    cover = np.where(seen.cover[nodes] > 0.0, seen.cover[nodes], _lengths(pair, seen)[nodes])
    seen.tractions[:, nodes] = seen.forces[:, nodes] / cover
    seen.cover[nodes] = seen.grip[nodes] = cover
    return seen


def corner_pieces(pair: OperatorPair) -> Ints:
    """Return the integration segments in use that are corners of the master on segments of the slave."""
    return np.flatnonzero(pair.pieces.segment[: pair.count, 0] < 0).astype(np.int32)


def _lengths(pair: OperatorPair, seen: ContactSnapshot) -> Floats:
    """Return the integrals (m,) [mm] of the shape functions of the slave's nodes."""
    slave = pair.slave
    edge = np.bincount(slave.segment_edge[:, 0], slave.lengths(seen.at.slave))
    shares = (0.5, 0.5) if slave.edges.shape[1] == 2 else (1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0)
    found = np.bincount(slave.edges.ravel(), np.outer(edge, shares).ravel(), len(slave.nodes))
    return np.asarray(found, np.float64)


def _add(seen: ContactSnapshot, forces: Floats, given: Floats, gap: Floats) -> None:
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


def _of_points(pair: OperatorPair, multipliers: Floats, slots: int) -> tuple[Floats, Floats]:
    """Return normal and tangential forces (2, k, 2) [N] of points at nodes with multipliers, and gaps (k,) [mm]."""
    points, given, gap = cast("CornerPair", pair.points), np.zeros((2, slots, 2)), np.zeros(slots)
    known = multipliers[:, points.own]
    for touch in points.touched:
        nodes = pair.slave.segments[touch.segment]
        # opposite to the normal and the tangent of the point, whose slave is the master here
        for part, direction in enumerate((-touch.outward, touch.along)[: len(known)]):
            given[part, nodes] += known[part, touch.corner] * np.outer((1.0 - touch.xi, touch.xi), direction)
        gap[nodes] = points.gaps[touch.corner, 0]
    inner, *beside = pair.between
    for values in given:
        for carriers in beside:
            np.add.at(values, carriers, 0.5 * values[inner])
        values[inner] = 0.0
    return given, gap
