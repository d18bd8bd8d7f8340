"""Touching nodes of two surfaces, for any contact algorithm."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from contactlab.api import Floats, Surface
from contactlab.kernels.contact.search import near_segments
from contactlab.model.bodies.body import NO_JOINTS, Joints
from contactlab.model.contact.systems import ContactPlan

TOUCH = 1e-6  # of a segment: round-off of matching meshes


def touching(plans: Iterable[ContactPlan], positions: Floats) -> Joints:
    """Return nodes on both sides of all contacts that lie on an edge of the other side at `positions` (N, 2)."""
    ways = [both for plan in plans for both in ((plan.slave, plan.master), (plan.master, plan.slave))]
    found = [_nodes_on_edges(own, other, positions) for own, other in ways]
    return Joints(*map(np.concatenate, zip(*found, strict=True))) if found else NO_JOINTS


def _nodes_on_edges(own: Surface, other: Surface, positions: Floats) -> Joints:
    x, y = positions[own.nodes], positions[other.nodes]
    reach = TOUCH * float(np.hypot(*np.ptp(y[other.segments], axis=1).T).max())
    near = near_segments(x, own.segments, y, other.segments, reach)
    segment = np.repeat(np.arange(len(own.segments)), np.diff(near.start))
    node = own.segments[segment].ravel()
    ends = np.repeat(other.segments[near.master], 2, axis=0)
    a, along = y[ends[:, 0]], y[ends[:, 1]] - y[ends[:, 0]]
    share = np.clip(((x[node] - a) * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
    closed = np.flatnonzero(np.hypot(*(a + share[:, None] * along - x[node]).T) <= reach)
    _, first = np.unique(node[closed], return_index=True)
    chosen = closed[first]
    return Joints(own.nodes[node[chosen]], other.nodes[ends[chosen]], share[chosen])
