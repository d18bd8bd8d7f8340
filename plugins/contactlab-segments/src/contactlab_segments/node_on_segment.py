"""One-pass node-on-segment contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import (
    Candidates,
    ContactAlgorithm,
    ContactView,
    Floats,
    GapGradients,
    Ints,
    Pieces,
    Surface,
    SurfacePositions,
)
from contactlab.api.compiled.bound_arrays import BoundArrays, BoundCache
from contactlab.api.compiled.contact_tables import PiecesTable, SurfaceTable
from contactlab.api.compiled.late import late

_BOUND = BoundCache()
_AXES = np.arange(2)
_ENDS = np.array([-1.0, 1.0])
_HALVES = np.array([-0.5, 0.5])  # of the two nodes of an edge beside a vertex

ROUND = 1e-9  # sine of an angle that is round-off
DEPTH = 1.0  # segment lengths: a node deeper than this is on the far side of a thin body


@dataclass(frozen=True)
class NodeOnSegment(ContactAlgorithm):
    """Slave nodes stay outside the nearest master segment, or the parabola of a quadratic edge.

    D = T = the length that the node stands for, half of its edges or 1/6, 4/6 and 1/6 of a quadratic one; M = that
    length times the segment's shape functions. So multipliers come out as pressures like those of the mortar methods.
    At a concave corner of the master both segments hold the node. Convex corners and ends of the master are points that
    stay outside the slave's segments (`corners`).
    """

    passes_patch_test: ClassVar[bool] = False
    keeps_energy: ClassVar[bool] = True
    rows_per_node: ClassVar[int] = 2
    memory_size: ClassVar[int] = 2
    gradient_nodes: ClassVar[int] = 1
    closest_points: ClassVar[bool] = True

    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        """One slave node, or the two of a segment that a corner presses on; one multiplier; one master edge."""
        return 2, 1, master.edges.shape[1]

    def capacity(self, slave: Surface, near: Candidates) -> int:
        """Two conditions per slave node."""
        return 2 * len(slave.nodes)

    def pieces(self, view: ContactView, out: Pieces) -> int:
        """The nearest segment of every slave node; `memory` keeps its number (plus one)."""
        address = _BOUND.of(out, _bound, view).address
        return int(late("contactlab_segments.pairing").pair_nodes(address, view.reach, DEPTH))

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Normals of segments turn with them; weights that change move the foot along the master, across the normal."""
        out.count = out.normal_count = 0
        along, share = _tangents(pieces, count, view.at)
        length = np.hypot(along[:, 0], along[:, 1])
        multiplier = pieces.multiplier[:count, 0]
        normal, apart = pieces.normal[multiplier], separation[multiplier]
        node = pieces.slave[:count, 0] == pieces.slave[:count, 1]
        of_segment = np.abs(normal[:, 0] * along[:, 0] + normal[:, 1] * along[:, 1]) <= ROUND * length
        beside = np.abs(normal[:, 0] * apart[:, 1] - normal[:, 1] * apart[:, 0])
        usable = np.flatnonzero(of_segment & node)
        tangent, share = along[usable] / length[usable, None], share[usable] / length[usable, None]
        shift = len(view.slave.nodes)
        put = _put_turns(multiplier[usable], tangent, tangent, share, shift + pieces.master[:count][usable], out)
        if put and not node.all():
            ends = pieces.slave[:count][~node]
            edge = view.at.slave[ends[:, 1]] - view.at.slave[ends[:, 0]]
            size = np.hypot(edge[:, 0], edge[:, 1])[:, None]
            put = _put_turns(multiplier[~node], edge / size, -edge / size, _ENDS / size, ends, out)
        # a vertex holds along the line to the node, which changes no gap as it turns; between two segments' it may
        between = np.flatnonzero(~of_segment & node & (beside > ROUND * length.max(initial=0.0)))
        if not put or not len(between):
            return put
        # the normal between two turns by half of the sum of what they do
        ends = view.master.segments[view.master.node_segments[pieces.master[between, 0]]].reshape(-1, 2)
        edge = view.at.master[ends[:, 1]] - view.at.master[ends[:, 0]]
        size = np.hypot(edge[:, 0], edge[:, 1])[:, None]
        across = np.repeat(normal[between][:, ::-1] * (-1.0, 1.0), 2, axis=0)
        return _put_turns(np.repeat(multiplier[between], 2), edge / size, across, _HALVES / size, shift + ends, out)

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        """Normals of the same segments at `at`: the master's, or the slave's where a corner presses on it."""
        along, _ = _tangents(pieces, count, view.at)
        pressed = pieces.slave[:count, 0] != pieces.slave[:count, 1]
        if pressed.any():
            ends = view.at.slave[pieces.slave[:count][pressed]]
            along[pressed] = ends[:, 0] - ends[:, 1]
        length = np.hypot(along[:, 0], along[:, 1])
        usable = length > 0.0
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1)[usable] / length[usable, None]
        out[:] = pieces.normal
        out[pieces.multiplier[:count, 0][usable]] = normal


def _bound(out: Pieces, view: ContactView) -> BoundArrays:
    """The arrays that pieces are made from and written to, with room for normals and lengths of both surfaces."""
    slave, master = (SurfaceTable(s.segments, s.node_segments, s.edges, s.segment_edge) for s in view[:2])
    nodes, others = len(view.slave.nodes), len(view.master.nodes)
    own, other = ((np.empty((s, 2)), np.empty(s)) for s in (len(view.slave.segments), len(view.master.segments)))
    return BoundArrays(
        late("contactlab_segments.tables").PairingTable, slave, master, *view.at, view.near.start, view.near.master,
        view.memory, *own, *other, np.empty((nodes, 2)), np.empty(nodes),
        np.empty(nodes, np.bool_), np.empty(nodes, np.int32),
        np.empty(others, np.int32), np.empty(others),
        PiecesTable(out.slave, out.multiplier, out.master, out.D, out.M, out.T, out.normal),
    )  # fmt: skip


def _put_turns(
    multiplier: Ints, tangent: Floats, across: Floats, share: Floats, nodes: Ints, out: GapGradients
) -> bool:
    """Append derivatives of normals that turn along `across` as edges do, by t x d(edge)/|edge|; False without room.

    multiplier (p,), the edges' unit tangents t (p, 2), `share` (p, r) [1/mm] of the nodes (p, r) in them.
    """
    first = out.normal_count
    end = first + 2 * share.size
    if end > len(out.normal_of):
        return False
    shape = *share.shape, 2
    turn = (tangent[:, ::-1] * (-1.0, 1.0))[:, None, :] * share[:, :, None]
    out.normal_of[first:end].reshape(shape)[:] = multiplier[:, None, None]
    np.add(2 * nodes[:, :, None], _AXES, out=out.normal_moved[first:end].reshape(shape))
    np.multiply(turn[..., None], across[:, None, None, :], out=out.dnormal[first:end].reshape(*shape, 2))
    out.normal_count = end
    return True


def _tangents(pieces: Pieces, count: int, at: SurfacePositions) -> tuple[Floats, Floats]:
    """Along the master (count, 2) at the feet, zero at vertices, and the share (count, r) of its nodes in that."""
    edge = at.master[pieces.master[:count]]
    share = np.zeros(edge.shape[:2])
    share[:, 0], share[:, 1] = -1.0, 1.0
    if edge.shape[1] == 2:
        return edge[:, 1] - edge[:, 0], share
    # at parameter s the tangent is (b - a)/2 + s (a + b - 2 m); s from the weights of start and end
    weight = pieces.M[:count, :, 0] / pieces.T[:count, 0]
    s = 2.0 * (weight[:, 1] - weight[:, 0])
    share += np.stack([s, s, -2.0 * s], axis=1)
    return np.einsum("pr,prd->pd", share, edge), share
