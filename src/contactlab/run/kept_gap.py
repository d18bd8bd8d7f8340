"""Nodes that press while they stand off the other side's curve, or lie within it, and what that changes.

A gap averaged over the segments of a node is zero before the node touches a side that curves away by as much, and a
node on a facet lies within the curve. In statics the equations at the end say what such distances change: they are
solved for gaps that close by them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse.linalg import splu

from contactlab.meshing.curves import distances_to_curve
from contactlab.run.stability import linearised

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair
    from contactlab.model.implicit_model import ImplicitModel

HIGH = 0.01  # of a force or of the largest displacement


class KeptGap(NamedTuple):
    """A pair with the node that is furthest off, and what all distances of the model change.

    apart  [mm] of the node, negative within the other side
    share  of the pair's force that is too much, negative where it is too small
    moved  the largest change of a displacement over the largest displacement of the model
    """

    pair: ContactPair
    node: int
    apart: float
    share: float
    moved: float


def kept_gaps(model: ImplicitModel, pairs: list[ContactPair], stored: float) -> Iterator[KeptGap]:
    """Pairs whose force kept distances change by more than 1 %; if none, the widest one where they move bodies so far.

    pairs   those whose gaps begin as the distances of their curves
    stored  [mJ] energy of the bodies: forces times distances over twice of it are about the share that is solved for,
            which takes a factorisation
    """
    assert model.contact is not None
    force = np.maximum(0.0, model.state["multipliers"][0])
    apart = np.zeros_like(force)
    for pair in pairs:
        pressed = np.flatnonzero(force[pair.own])
        own = pair.slave.nodes[pressed % len(pair.slave.nodes)]
        points = model.position[own]
        apart[pair.own][pressed] = distances_to_curve(points, pair.master, model.position, model.reference)
    apart -= np.where(force > 0.0, model.contact.conditions.gap, 0.0)  # what a penalty leaves
    if not force @ np.abs(apart) > HIGH * stored > 0.0:
        return
    equations = linearised(model)
    closing = np.where(equations.conditions < 0, 0.0, apart[equations.conditions])
    n = equations.matrix.shape[0] - len(closing)
    try:
        change = splu(equations.matrix).solve(np.concatenate([np.zeros(n), closing]))
    except RuntimeError:
        return  # a motion that nothing resists
    added = np.zeros_like(force)
    added[equations.conditions[equations.conditions >= 0]] = -change[n:][equations.conditions >= 0]
    moved = float(np.abs(change[:n]).max()) / float(np.abs(model.state["displacement"]).max())
    shares = [float(added[pair.own].sum() / force[pair.own].sum()) for pair in pairs]
    widest = max(pairs, key=lambda pair: float(np.abs(apart[pair.own]).max()))
    for pair, share in zip(pairs, shares, strict=True):
        if abs(share) > HIGH or (pair is widest and moved > HIGH and not any(np.abs(shares) > HIGH)):
            furthest = int(np.abs(apart[pair.own]).argmax())
            node = pair.slave.nodes[furthest % len(pair.slave.nodes)]
            yield KeptGap(pair, node, float(apart[pair.own][furthest]), share, moved)
