"""Nodes that press while they stand off the other side's curve, or lie within it, and what that changes.

A gap averaged over the segments of a node is zero before the node touches a side that curves away by as much, and a
node on a facet lies within the curve. In statics the equations at the end say what such distances change: they are
solved for gaps that close by them. A potential has no gaps to close: it sees nodes moved along their forces by as much
as the curve of the other side is in front of its facets, and of nodes that stand off these.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
from scipy.sparse.linalg import splu

from contactlab.api import Floats, Ints, PointContact
from contactlab.contact.corner_report import corner_pieces
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.meshing.curves import distances_to_curve, distances_to_facets
from contactlab.model.implicit_model import ImplicitModel
from contactlab.run.stability import linearised

if TYPE_CHECKING:
    from contactlab.contact.potential_pair import PotentialPair

HIGH = 0.01  # of a force or of the largest displacement


class KeptGap(NamedTuple):
    """A pair with the node that is furthest off, and what all distances of the model change.

    apart  [mm] of the node, negative within the other side
    share  of the pair's force that is too much, negative if it is too small
    moved  the largest change of a displacement over the largest displacement of the model
    """

    pair: ContactPair
    node: int
    apart: float
    share: float
    moved: float


class _Distances(NamedTuple):
    """Distances of one pair's nodes.

    nodes   (n,) of the model
    apart   (n,) [mm] distance of each from the curve, negative within it
    force   (n,) [N] by which each is pressed
    inward  (n, 2) directions of these forces, zero without a force; (0, 2) of pairs that set conditions
    """

    pair: ContactPair
    nodes: Ints
    apart: Floats
    force: Floats
    inward: Floats


def kept_gaps(model: ImplicitModel, pairs: list[ContactPair], stored: float) -> Iterator[KeptGap]:
    """Pairs whose force kept distances change by more than 1 %; if none, the widest one where they move bodies so far.

    pairs   those whose gaps begin as the distances of their curves
    stored  [mJ] energy of the bodies: forces times distances over twice of it are about the share that is solved for,
            which takes a factorisation
    """
    assert model.contact is not None
    found = [
        _of_gaps(model, pair) if (potential := _potential(pair)) is None else _of_potential(model, potential)
        for pair in pairs
    ]
    if not sum(float(one.force @ np.abs(one.apart)) for one in found) > HIGH * stored > 0.0:
        return
    equations = linearised(model)
    closing, forces = np.zeros(len(model.state["multipliers"][0])), np.zeros(model.reference.size)
    for one in found:
        if (potential := _potential(one.pair)) is not None:
            np.subtract.at(forces, potential.dof, potential.stiffness() @ _shift(one))
        else:
            closing[one.pair.own] = one.apart
    closing = np.where(equations.conditions < 0, 0.0, closing[equations.conditions])
    n = equations.matrix.shape[0] - len(closing)
    try:
        change = splu(equations.matrix).solve(np.concatenate([forces[equations.free], closing]))
    except RuntimeError:
        return  # a motion that nothing resists
    motion, added = np.zeros(model.reference.size), np.zeros(len(model.state["multipliers"][0]))
    motion[equations.free] = change[:n]
    added[equations.conditions[equations.conditions >= 0]] = -change[n:][equations.conditions >= 0]
    moved = float(np.abs(change[:n]).max()) / float(np.abs(model.state["displacement"]).max())
    shares = [_share(one, motion, added) for one in found]
    widest = max(found, key=lambda one: float(np.abs(one.apart).max()))
    for one, share in zip(found, shares, strict=True):
        if abs(share) > HIGH or (one is widest and moved > HIGH and not any(np.abs(shares) > HIGH)):
            furthest = int(np.abs(one.apart).argmax())
            yield KeptGap(one.pair, int(one.nodes[furthest]), float(one.apart[furthest]), share, moved)


def _of_gaps(model: ImplicitModel, pair: ContactPair) -> _Distances:
    """Distances of pressed nodes, or of corners of the master that are pressed; 0 of other conditions."""
    assert model.contact is not None
    force = np.maximum(0.0, model.state["multipliers"][0, pair.own])
    nodes, apart = pair.slave.nodes[np.arange(len(force)) % len(pair.slave.nodes)], np.zeros(len(force))
    pressed = np.flatnonzero(force)
    points = model.position[nodes[pressed]]
    apart[pressed] = distances_to_curve(points, pair.master, model.position, model.reference)
    if isinstance(pair, OperatorPair) and isinstance(pair.method, PointContact):
        at = corner_pieces(pair.pieces, pair.count)
        slot, corner = pair.pieces.multiplier[at, 0], pair.master.nodes[pair.pieces.master[at, 0]]
        nodes[slot] = corner
        off = distances_to_curve(model.position[corner], pair.slave, model.position, model.reference)
        apart[slot] = np.where(force[slot] > 0.0, off, 0.0)
    apart -= np.where(force > 0.0, model.contact.conditions.gap[pair.own], 0.0)  # what a penalty leaves
    return _Distances(pair, nodes, apart, force, np.zeros((0, 2)))


def _of_potential(model: ImplicitModel, pair: PotentialPair) -> _Distances:
    """Depth of pushed nodes of both sides within the other curve, less their depth within its facets."""
    apart = np.zeros(len(pair.nodes))
    pushed = pair.pushed.any(axis=1)
    of_slave = np.arange(len(apart)) < len(pair.slave.nodes)
    for own, other in ((of_slave, pair.master), (~of_slave, pair.slave)):
        pressed = np.flatnonzero(own & pushed)
        points = model.position[pair.nodes[pressed]]
        off = distances_to_facets(points, other, model.position)
        within = distances_to_curve(points, other, model.position, model.reference)
        apart[pressed] = np.minimum(within - off + np.maximum(off - pair.opened, 0.0), 0.0)
    force = np.hypot(*pair.pushed.T)
    inward = np.divide(pair.pushed, force[:, None], out=np.zeros_like(pair.pushed), where=force[:, None] > 0.0)
    return _Distances(pair, pair.nodes, apart, force, inward)


def _shift(one: _Distances) -> Floats:
    """Motion (2n,) [mm] of nodes along their forces, inwards, that closes what a potential does not see."""
    return np.asarray(-one.apart[:, None] * one.inward).ravel()


def _share(one: _Distances, motion: Floats, added: Floats) -> float:
    """Share of the force on the slave that distances add, if closing them moves nodes by `motion` (2N,) [mm]."""
    potential = _potential(one.pair)
    if potential is None:
        return float(added[one.pair.own].sum() / one.force.sum())
    m = len(potential.slave.nodes)
    more = (potential.stiffness() @ (motion[potential.dof] + _shift(one))).reshape(-1, 2)[:m]
    return -float((more * one.inward[:m]).sum() / one.force[:m].sum())


def _potential(pair: ContactPair) -> PotentialPair | None:
    """The pair if its forces come from an energy, told without the module of such pairs."""
    return cast("PotentialPair", pair) if pair.by_energy else None
