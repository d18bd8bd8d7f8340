"""Corners of the master in a mortar contact: the slave segment that each touches, and its constraint.

A mean gap over a segment that a corner touches lets the corner penetrate, and changes as the segment slides past:
forces along its derivatives hinder sliding. If the node beyond a corner has a multiplier but nothing below it,
its constraint is therefore taken at the corner, between both nodes of the segment. Other corners are points of their
own that stay outside the slave (`contactlab.contact.corner_pair`), slightly deeper than mean gaps of flat flanks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Ints, Rows, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.contact.operator_pair import OperatorPair
from contactlab.kernels.contact.corners import take_row, touches
from contactlab.kernels.contact.search import Near

SHARP = 0.5  # sine by which the master turns outward at a corner
CLOSE = 3.0  # segments: corners farther from all nodes of the slave touch it in no step of a near list
FAR = 0.25  # of the extent of the slave: corners cannot hold a trial that moves nodes so far in a step
CLOSED, APART = 0.01, 0.05  # of a segment: distances up to which flanks may be touched, and from which none is
SLACK = 0.002  # of the shortest segment of the slave: depth of a point before it bears


class Touch(NamedTuple):
    """Corner `corner` of the master near slave segment `segment`: its projection, gap [mm], and the segment.

    along   (2,) unit vector along the segment, outward (2,) its normal; length [mm]
    """

    corner: int
    segment: int
    xi: float
    gap: float
    along: Floats
    outward: Floats
    length: float

    @property
    def rates(self) -> Floats:
        """Derivatives (3, 2) [1/mm] of xi by the corner and the two nodes of the segment."""
        by_corner = self.along / self.length
        by_end = (self.gap / self.length * self.outward - self.xi * self.along) / self.length
        return np.stack([by_corner, -by_corner - by_end, by_end])


class Moved(NamedTuple):
    """A constraint of multiplier `slot` taken at a corner: `share` of it and the remainder of `partner`.

    nodes  (3,) global nodes by which the share changes, with `rates` (3, 2) [1/mm]
    """

    slot: int
    partner: int
    share: float
    nodes: Ints
    rates: Floats


class Corners:
    """Corners of the master of a mortar pair. `points` act as points, constraints `moved` are taken at the others.

    nodes     nodes (c,) of the master that are corners
    slack     [mm] depth of a point before it bears on a segment that may lie on a flank
    depth     [mm] the same for each point
    opened    nodes around points whose flanks are not touched, and least distances [mm] there
    close     corners near the slave
    start     (m, 2) [mm] the slave's nodes at the start of the step, if steps iterate
    """

    def __init__(self, pair: OperatorPair, nodes: Ints) -> None:
        self.pair, self.nodes = pair, nodes
        self.slack = SLACK * float(pair.slave.lengths(pair.at.slave).min())
        self.near: Near | None = None
        self.close = nodes[:0]
        self.moved: list[Moved] = []
        self.points: list[Touch] = []
        self.depth: dict[int, float] = {}
        self.opened: list[tuple[Ints, Floats]] = []
        self.start: Floats | None = None
        slave = pair.slave
        # multipliers at the ends of quadratic edges span both halves
        self._on_edges = not pair.algorithm.carriers(slave).all()
        edge, half = slave.segment_edge.T
        self._span_of = edge if self._on_edges else np.arange(len(slave.segments))
        self._ends = slave.edges[edge, :2] if self._on_edges else slave.segments  # nodes (s, 2) of the span of each
        self._begin, self._share = (0.5 * half, 0.5) if self._on_edges else (0.0 * half, 1.0)  # of it in its span

    @property
    def touching(self) -> bool:
        """True if any corner has a constraint."""
        return bool(self.moved or self.points)

    def update(self) -> None:
        """Find the contact of each corner at the present positions, and take constraints there."""
        if self.pair.near is not self.near:
            self._list_segments()
        if self.touching:
            self.moved, self.points, self.opened = [], [], []
        if not len(self.close) or self._is_far():
            return
        for touch in self.touches(self.pair.at):
            moved = self._moved(touch)
            if moved is not None:
                self.moved.append(moved)
            # a mean gap, linear along a quadratic edge, misses how far a corner bends it
            if moved is None or self._on_edges:
                apart = self._open(touch) / touch.length if moved is None else 0.0
                self.points.append(touch)
                self.depth[touch.corner] = self.slack * float(np.interp(apart, [CLOSED, APART], [1.0, 0.0]))
        self.take(self.pair.gaps)

    def _is_far(self) -> bool:
        if self.start is None:
            return False
        moved, extent = self.pair.at.slave - self.start, np.ptp(self.start, axis=0)
        return bool(np.hypot(*moved.T).max() > FAR * np.hypot(*extent))

    def touches(self, at: SurfacePositions) -> list[Touch]:
        """Return the contacts of corners with both sides at the positions `at`."""
        if not len(self.close):
            return []
        slave, master, segment, found = self.pair.slave, self.pair.master, self._segment, self._found
        own, other = (at.slave, slave.segments, slave.node_segments), (at.master, master.segments, master.node_segments)
        if not touches(self.close, self._start, self._above, own, other, self.pair.size, segment, found):
            return []
        return [
            Touch(int(self.close[c]), int(segment[c]), x[0], x[1], x[2:4], x[4:6], x[6])
            for c in np.flatnonzero(segment >= 0)
            for x in (found[c].copy(),)
        ]

    def _list_segments(self) -> None:
        """List corners near the slave, and its segments near each corner."""
        self.near, pair, master = self.pair.near, self.pair, self.pair.master
        assert self.near is not None
        candidates = self.near.candidates
        slave = np.repeat(np.arange(len(candidates.start) - 1, dtype=np.int32), np.diff(candidates.start))
        close = [
            v for v in self.nodes if np.hypot(*(self.near.slave - self.near.master[v]).T).min() <= CLOSE * pair.size
        ]
        above = [np.unique(slave[np.isin(candidates.master, master.node_segments[v])]) for v in close]
        self.close = np.array(close, np.int32)
        self._start = np.cumsum([0, *map(len, above)]).astype(np.int32)
        self._above = np.concatenate([np.zeros(0, np.int32), *above])
        self._segment, self._found = np.zeros(len(self.close), np.int32), np.zeros((len(self.close), 7))

    def _moved(self, touch: Touch) -> Moved | None:
        """Return the constraint of the node beyond a corner; None if merged, or if something else is below the node."""
        pair, slave = self.pair, self.pair.slave
        seen, ends, owner = pair.pieces.segment[: pair.count, 0], pair.pieces.ends, pair.coupling.owner
        nodes, first, length = self._ends[touch.segment], float(self._begin[touch.segment]), self._share
        own = np.flatnonzero(self._span_of[seen] == self._span_of[touch.segment])
        if not len(own) or not 0.0 < touch.xi < 1.0:
            return None
        before = self._begin[seen[own]]
        covered = (before + length * ends[own, 0]).min() <= 0.0, (before + length * ends[own, 2]).max() >= 1.0
        if covered[0] == covered[1]:
            return None
        end = int(covered[0])
        slot, partner = int(nodes[end]), int(nodes[1 - end])
        beyond = slave.node_segments[slot, end]
        if owner[slot] != slot or owner[partner] != partner or (beyond >= 0 and self._sees(beyond)):
            return None
        place = first + length * touch.xi
        moves = np.append(pair.master.nodes[touch.corner], slave.nodes[slave.segments[touch.segment]])
        share, sign = (place, length) if end else (1.0 - place, -length)
        return Moved(slot, partner, share, moves, sign * touch.rates)

    def _sees(self, segment: int) -> bool:
        """Return whether any segment in the span of a segment sees the master."""
        seen = self.pair.pieces.segment[: self.pair.count, 0]
        return bool((self._span_of[seen] == self._span_of[segment]).any())

    def _open(self, touch: Touch) -> float:
        """Open constraints around a corner within a segment that sees both of its flanks and touches neither.

        Distances are zero at the corner and grow along both flanks. Means of them, extrapolated to nodes, may be
        negative; they are at least the smallest distance beside the corner. Returns that of the segment [mm].
        """
        pair, count = self.pair, self.pair.count
        (segment, flank), ends = pair.pieces.segment[:count].T, pair.pieces.ends[:count]
        own = segment == touch.segment
        if not (0.0 < touch.xi < 1.0 and np.isin(pair.master.node_segments[touch.corner], flank[own]).all()):
            return 0.0
        (a, b), (c, d) = (at[side].transpose(1, 0, 2) for at, side in (
            (pair.at.slave, pair.slave.segments[segment]), (pair.at.master, pair.master.segments[flank])
        ))  # fmt: skip
        edge = b - a
        outward = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.hypot(*edge.T)[:, None]
        least, corner = np.full(pair.slots, np.inf), pair.at.master[touch.corner]
        nodes = self._ends[segment]
        for low in (0, 2):
            xi, eta = ends[:, low, None], ends[:, low + 1, None]
            seen = c + eta * (d - c)
            gap = ((seen - a - xi * edge) * outward).sum(axis=1)
            gap[np.hypot(*(seen - corner).T) < CLOSED * touch.length] = np.inf
            np.minimum.at(least, nodes, gap[:, None])
        span = self._ends[touch.segment]
        around = np.unique(nodes[np.isin(nodes, span).any(axis=1)])
        around = around[(least[around] > CLOSED * touch.length) & np.isfinite(least[around])]
        self.opened.append((around, least[around]))
        self.lift(pair.gaps)
        return float(least[span].min())

    # --- constraints taken at corners -----------------------------------------------------

    def lift(self, gaps: Floats) -> None:
        """Raise gaps (k, ...) [mm] of opened constraints to the least distances between both sides."""
        for nodes, least in self.opened:
            gaps[nodes, 0] = np.maximum(gaps[nodes, 0], least)

    def take(self, values: Floats) -> None:
        """Take values (k, ...) of multipliers, whose first column are gaps, at the corners."""
        for slot, partner, share, _, _ in self.moved:
            values[slot, 0] = share * values[slot, 0] + (1.0 - share) * values[partner, 0]

    def change(self, moved: Moved, values: Floats) -> float:
        """Return the change of a value of (k,), taken at a corner, by its share."""
        return float((values[moved.slot] - values[moved.partner]) / moved.share)

    def at_nodes(self, forces: Floats) -> Floats:
        """Return forces (r, k) at the nodes of multipliers, from forces at corners."""
        forces = forces.copy()
        for slot, partner, share, _, _ in self.moved:
            forces[:, partner] += (1.0 - share) * forces[:, slot]
            forces[:, slot] *= share
        return forces

    def take_rows(self, rows: Rows, first: int, entries: int) -> int:
        """Take rows from `first` on at the corners. Return the next free entry, or -1 without room."""
        slot = rows.slot[first : rows.count] - self.pair.first_slot
        for moved in self.moved:
            own, other = (first + int(np.flatnonzero(slot == k)[0]) for k in (moved.slot, moved.partner))
            shares = moved.share, 1.0 - moved.share
            change = self.change(moved, self.pair.gaps[:, 0]) * moved.rates
            arrays = rows.start, rows.node, rows.normal_weight, rows.tangent_weight
            more = take_row(*arrays, rows.count, own, other, shares, moved.nodes, change)
            if more < 0:
                return -1
            entries += more
            if len(rows.slip):
                rows.slip[own] = shares[0] * rows.slip[own] + shares[1] * rows.slip[other]
        return entries


def corners_of(surface: Surface, positions: Floats) -> Ints:
    """Return nodes (c,) of a surface at `positions` (N, 2) at which it ends or turns outward."""
    at = positions[surface.nodes]
    edge = at[surface.segments[:, 1]] - at[surface.segments[:, 0]]
    edge /= np.hypot(edge[:, 0], edge[:, 1])[:, None]
    before, after = surface.node_segments.T
    one, other = edge[before], edge[after]
    turn = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    sharp = (turn > SHARP) | ((turn > 0.0) & ((one * other).sum(axis=1) < 0.0))
    return np.flatnonzero((before < 0) | (after < 0) | sharp).astype(np.int32)
