"""Corners of the master in a mortar contact: the slave segment that each touches, and its constraint.

A mean gap over a segment that a corner touches lets the corner penetrate, and changes as the segment slides past:
forces along its derivatives hinder sliding. If the node beyond a corner has a multiplier but nothing below it,
its constraint is therefore taken at the corner, between both nodes of the segment. Other corners are points of their
own that stay outside the slave (`contactlab.contact.corner_pair`), slightly deeper than mean gaps of flat flanks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contactlab.api import Candidates, ContactView, Floats, Ints, Rows, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.kernels.contact.corners import take_row, touches

if TYPE_CHECKING:
    from contactlab.contact.operator_pair import OperatorPair
    from contactlab.kernels.contact.search import Near

SHARP = 0.5  # sine by which the master turns outward at a corner
CLOSE = 3.0  # segments: corners farther from all nodes of the slave touch it in no step of a near list
FAR = 0.25  # of the extent of the slave: corners cannot hold a trial that moves nodes so far in a step
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
    slack     [mm] depth of a point before it bears
    close     corners near the slave
    found     the contact of each that touches a segment
    start     (m, 2) [mm] the slave's nodes at the start of the step, if steps iterate
    """

    def __init__(self, pair: OperatorPair, nodes: Ints) -> None:
        self.pair, self.nodes = pair, nodes
        self.slack = SLACK * float(pair.slave.lengths(pair.at.slave).min())
        self.near: Near | None = None
        self.close = nodes[:0]
        self.found: list[Touch] = []
        self.moved: list[Moved] = []
        self.points: list[Touch] = []
        self.start: Floats | None = None

    @property
    def touching(self) -> bool:
        """True if any corner has a constraint."""
        return bool(self.moved or self.points)

    def find(self, view: ContactView) -> ContactView:
        """Find the contact of each corner at the present positions. Return the view without flanks beyond a corner.

        A segment that a corner touches between its ends may see both flanks. The gap is zero at the corner and grows
        along both; extrapolated to a node it may be negative though nothing is deep, and then neither a force nor
        none is an equilibrium. The flank that faces the segment less is left out: the corner holds the segment.
        """
        if self.pair.near is not self.near:
            self._list_segments()
        if self.touching:
            self.moved, self.points = [], []
        self.found = [] if not len(self.close) or self._is_far() else self.touches(self.pair.at)
        behind = [(touch.segment, flank) for touch in self.found if (flank := self._flank(touch)) >= 0]
        if not behind:
            return view
        (start, master, reach), kept = view.near, np.ones(len(view.near.master), np.bool_)
        for segment, flank in behind:
            row = slice(start[segment], start[segment + 1])
            kept[row] &= master[row] != flank
        places = np.append(0, np.cumsum(kept)).astype(np.int32)
        return view._replace(near=Candidates(places[start], master[kept], reach))

    def _flank(self, touch: Touch) -> int:
        """Return the flank of a corner within its segment that faces this less than the other does, or -1."""
        flanks = self.pair.master.node_segments[touch.corner]
        if not 0.0 < touch.xi < 1.0 or flanks.min() < 0:
            return -1
        edge = np.diff(self.pair.at.master[self.pair.master.segments[flanks]], axis=1)[:, 0]
        against = edge @ touch.along / np.hypot(*edge.T)  # -1 if parallel
        return int(flanks[np.argmax(against)]) if against.max() < 0.0 else -1

    def update(self) -> None:
        """Take constraints at the corners that were found."""
        if not self.found:
            return
        for touch in self.found:
            moved = self._moved(touch)
            if moved is None:
                self.points.append(touch)
            else:
                self.moved.append(moved)
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
        own = np.flatnonzero(seen == touch.segment)
        if not len(own) or not 0.0 < touch.xi < 1.0:
            return None
        covered = ends[own, 0].min() <= 0.0, ends[own, 2].max() >= 1.0
        if covered[0] == covered[1]:
            return None
        end = int(covered[0])
        slot, partner = (int(i) for i in slave.segments[touch.segment, [end, 1 - end]])
        if owner[slot] != slot or owner[partner] != partner or (seen == slave.node_segments[slot, end]).any():
            return None
        nodes = np.append(pair.master.nodes[touch.corner], slave.nodes[slave.segments[touch.segment]])
        share, sign = (touch.xi, 1.0) if end else (1.0 - touch.xi, -1.0)
        return Moved(slot, partner, share, nodes, sign * touch.rates)

    # --- constraints taken at corners -----------------------------------------------------

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
