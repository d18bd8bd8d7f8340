"""Length that nodes stand for where the master ends within a segment of the slave.

A condition of a node (`PointContact` at nodes) stands for all of the node's length, also where a part of it lies beyond
the end of the master. Forces of exact conditions do not depend on it; a traction per length does: slip stresses
(Tresca, cohesion) and pressure laws.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, PointContact, RunWarning, Surface
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair

HIGH = 0.01  # of the force
WITHIN = 0.02  # of a segment: nodes are held as far beyond an end


def end_lengths(model: Model, pair: ContactPair) -> Iterator[RunWarning]:
    """Warn of a force that follows from a traction per length, where nodes at ends stand for another length."""
    if not isinstance(pair.method, PointContact) or pair.method.points:
        return
    assert model.contact is not None
    force = model.state["multipliers"][:, pair.own]
    laws = []
    if hasattr(model.contact.enforcement, "law"):
        laws.append(("pressure", "its pressure law", np.maximum(force[0], 0.0)))
    if pair.sliding is not None and pair.sliding.of(slice(None))[1].any():
        laws.append(("friction", "its slip stress", force[1]))
    if not laws:
        return
    for what, whose, values in laws:
        share = excess_force(pair, values) / (float(values.sum()) or 1.0)
        if abs(share) <= HIGH:
            continue
        size = "large" if share > 0.0 else "small"
        yield RunWarning(
            "end-length", share, HIGH, f"{pair.name}.algorithm",
            f"{pair.name}: the master ends within a segment of the slave, whose nodes stand for their whole length: "
            f"the {what} by {whose} is {abs(share):.1%} too {size} (limit {HIGH:.0%}); take a mortar, which "
            "integrates over the overlap, or put nodes of the slave at the ends of the master",
        )  # fmt: skip


def excess_force(pair: ContactPair, values: Floats) -> float:
    """Return the excess of the forces (k,) [N] of a traction per length where the master ends within a segment.

    The segment's inner node, its outer node, if it is held, and the end of the master, if it presses as a corner, stand
    for a whole length each; correct is the largest of their tractions over the overlap.
    """
    slave, master, at, nodes = pair.slave, pair.master, pair.at, len(pair.slave.nodes)
    traction = np.divide(values, pair.cover, out=np.zeros_like(values), where=pair.cover > 0.0)
    begin, along = at.slave[slave.segments[:, 0]], np.diff(at.slave[slave.segments], axis=1)[:, 0]
    length = np.hypot(*along.T)
    tangent = along / length[:, None]
    excess = 0.0
    for end, (before, after) in enumerate(master.node_segments):
        if before >= 0 and after >= 0:
            continue
        inward = at.master[master.segments[max(before, after)]].sum(axis=0) - 2.0 * at.master[end]
        apart = at.master[end] - begin
        share = (apart * tangent).sum(axis=1) / length
        off = np.abs(apart[:, 0] * tangent[:, 1] - apart[:, 1] * tangent[:, 0])
        ahead = tangent @ inward > 0.0
        covered = np.where(ahead, 1.0 - share, share)
        for s in np.flatnonzero((covered > -WITHIN) & (covered <= 1.0 - WITHIN) & (off < length)):
            inner, outer = slave.segments[s][::-1] if ahead[s] else slave.segments[s]
            found = np.array([inner, outer, nodes + inner, nodes + outer])[: 2 * pair.rows_per_node]
            level = traction[found[np.abs(traction[found]).argmax()]]
            before_it = slave.node_segments[inner, 1 if ahead[s] else 0]
            right = max(float(covered[s]), 0.0) * length[s]
            right += _own_share(slave, int(before_it), int(inner)) * length[before_it] if before_it >= 0 else 0.0
            excess += values[found].sum() - level * right
    return float(excess)


def _own_share(surface: Surface, segment: int, node: int) -> float:
    """Share of a segment's length that one of its nodes stands for."""
    if surface.edges.shape[1] == 2:
        return 0.5
    return 2.0 / 3.0 if surface.edges[surface.segment_edge[segment, 0], 2] == node else 1.0 / 3.0
