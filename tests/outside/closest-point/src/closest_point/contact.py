"""Node-on-segment contact as finished gap conditions, in plain NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from contactlab.api import ConditionDerivatives, ContactView, Floats, GapAlgorithm, GapConditions, Ints

END = 0.02  # segment lengths that a node may stand beyond the end of a chain
HYSTERESIS = 1.02  # another segment must be nearer by this factor than the one of the last step


class _Feet(NamedTuple):
    """Held slave nodes (k,), the segment of each, its direction, normal and length, the foot in [0, 1], and the gap."""

    node: Ints
    segment: Ints
    along: Floats
    normal: Floats
    length: Floats
    share: Floats
    gap: Floats


def feet(view: ContactView) -> _Feet:
    """The nearest master segment of every slave node that faces one within reach."""
    slave, master, at, near, reach, memory = view
    owner = np.repeat(np.arange(len(slave.segments)), np.diff(near.start))
    node, segment = slave.segments[owner].ravel(), np.repeat(near.master, 2)
    start, end = at.master[master.segments[segment]].transpose(1, 0, 2)
    length = np.hypot(*(end - start).T)
    along = (end - start) / length[:, None]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    offset = at.slave[node] - start
    share, gap = dot(offset, along) / length, dot(offset, normal)
    first, last = (master.node_segments[master.segments[segment, side], side] >= 0 for side in (0, 1))
    outside = (share < np.where(first, -np.inf, -END)) | (share > np.where(last, np.inf, 1.0 + END))
    share = np.clip(share, 0.0, 1.0)
    distance = np.hypot(*(offset - (share * length)[:, None] * along).T)
    faces = dot(outward(view)[node], normal) < 0.0
    kept = np.flatnonzero(~outside & faces & (distance <= reach) & (gap >= -length.max(initial=0.0)))
    nearness = distance * np.where(segment + 1 == memory[0, node], 1.0, HYSTERESIS)
    ordered = kept[np.lexsort((nearness[kept], node[kept]))]
    chosen = ordered[np.unique(node[ordered], return_index=True)[1]]
    return _Feet(*(values[chosen] for values in (node, segment, along, normal, length, share, gap)))


def outward(view: ContactView) -> Floats:
    """Sum of the normals (m, 2) [mm] of the slave's segments at each of its nodes, times their lengths."""
    ends = view.at.slave[view.slave.segments]
    edge, out = ends[:, 1] - ends[:, 0], np.zeros_like(view.at.slave)
    np.add.at(out, view.slave.segments, np.stack([edge[:, 1], -edge[:, 0]], axis=1)[:, None])
    return out


def dot(one: Any, other: Any) -> Any:
    """Products (k,) of vectors (k, 2)."""
    return one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1]


@dataclass(frozen=True)
class Plain(GapAlgorithm):
    """Slave nodes stay outside the nearest master segment; `memory` keeps its number, plus one."""

    passes_patch_test: ClassVar[bool] = False
    memory_size: ClassVar[int] = 1

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        """Three entries each: the node, and both ends of its segment."""
        found = feet(view)
        view.memory[0] = 0.0
        view.memory[0, found.node] = found.segment + 1
        ends = view.master.nodes[view.master.segments[found.segment]]
        node = np.column_stack([view.slave.nodes[found.node], ends]).astype(np.int32)
        share = np.stack([np.ones_like(found.share), found.share - 1.0, -found.share], axis=1)
        weight = (share[..., None] * found.normal[:, None]).reshape(-1, 2)
        turned = np.stack([weight[:, 1], -weight[:, 0]], axis=1) if tangent else np.zeros((0, 2))
        start = np.arange(0, 3 * len(node) + 1, 3, dtype=np.int32)
        measure = self._lengths(view)[found.node]
        return GapConditions(start, node.ravel(), weight, turned, found.gap, measure, found.node)

    @staticmethod
    def _lengths(view: ContactView) -> Floats:
        """Half of the segments (m,) [mm] at each slave node."""
        ends, out = view.at.slave[view.slave.segments], np.zeros(len(view.at.slave))
        np.add.at(out, view.slave.segments, 0.5 * np.hypot(*(ends[:, 1] - ends[:, 0]).T)[:, None])
        return out


@dataclass(frozen=True)
class ClosestPoint(Plain):
    """The same, with derivatives of its own.

    With the direction t, the normal n and the length l of a segment from a to b, the foot s and the gap g of a node x:

        dn = -t (n . (db - da)) / l,    ds = ((dx - da) . t + g n . (db - da) / l - s t . (db - da)) / l
    """

    def derivatives(self, view: ContactView, found: GapConditions) -> ConditionDerivatives:
        """Of n, (s - 1) n and -s n by the three nodes; feet at the ends of a segment do not move along it."""
        at = feet(view._replace(memory=view.memory.copy()))
        inner = ((at.share > 0.0) & (at.share < 1.0)).astype(float)
        over, share, slide = 1.0 / at.length, at.share, inner / at.length
        # coefficients of n and of t in ds, for x, a and b
        by_normal = np.stack([0.0 * share, -slide * at.gap * over, slide * at.gap * over], axis=1)
        by_along = np.stack([slide, slide * (share - 1.0), -slide * share], axis=1)
        foot = by_normal[..., None] * at.normal[:, None] + by_along[..., None] * at.along[:, None]
        turn = np.zeros((len(share), 3, 2, 2))  # of the condition, node moved, its direction, component of dn
        turn[:, 2] = -(over[:, None, None]) * at.normal[:, :, None] * at.along[:, None, :]
        turn[:, 1] = -turn[:, 2]
        weight = np.stack([np.ones_like(share), share - 1.0, -share], axis=1)
        value = weight[:, :, None, None, None] * turn[:, None]
        for entry, sign in ((1, 1.0), (2, -1.0)):
            value[:, entry] += sign * foot[..., None] * at.normal[:, None, None]
        entries = np.arange(len(found.node)).reshape(-1, 3)[:, :, None, None]
        moved = 2 * found.node.reshape(-1, 1, 3, 1) + np.arange(2)
        entry, coordinate = np.broadcast_arrays(entries, moved)
        return ConditionDerivatives(entry.ravel(), coordinate.ravel(), value.reshape(-1, 2))
