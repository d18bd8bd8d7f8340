"""A pair of a mortar that holds corners of its master: at constraints taken there, and at points of their own."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, Rows
from contactlab.contact.corner_pair import CornerPair
from contactlab.contact.corner_report import add
from contactlab.contact.corners import Corners
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactSnapshot

LEAST = 0.5  # of its length: with less overlap a node spreads no corner force


class CorneredPair(OperatorPair):
    """A slave and a master surface with the `corners` of the master, from `hold` on.

    Reports show forces at corners, and of the pair of `points`, at the slave's nodes.
    """

    points: CornerPair

    def _prepare(self, reference: Floats) -> None:
        self.corners = Corners(self, np.zeros(0, np.int32))

    def hold(self, nodes: Ints, points: CornerPair) -> None:
        """Hold the corners at `nodes` (c,) of the master, of which some act as `points`."""
        self.points = points
        self.corners = points.corners = Corners(self, nodes)

    def _make(self, positions: Floats, compliance: Floats, force: Floats, memory: Floats, pushed: bool) -> None:
        super()._make(positions, compliance, force, memory, pushed)
        self.corners.update()

    def gaps_at(self, positions: Floats) -> Floats:
        """Return gaps (k, 2) at `positions`, with the corners of the last `update`."""
        gaps = super().gaps_at(positions)
        self.corners.take(gaps)
        self.corners.lift(gaps)
        return gaps

    @property
    def takes_rows(self) -> bool:
        """True if constraints of some nodes are taken at corners."""
        return bool(self.corners.moved)

    def take_rows(self, rows: Rows, first: int, entries: int) -> int:
        """Take rows from `first` on at the corners. Return the next free entry, or -1 without room."""
        return self.corners.take_rows(rows, first, entries)

    @property
    def holds_corners(self) -> bool:
        """True if any corner has a constraint."""
        return self.corners.touching

    def _at_nodes(self, seen: ContactSnapshot, multipliers: Floats) -> ContactSnapshot:
        """Return the snapshot with nodal forces that include corner forces.

        The resultant contains all forces. Forces of points, and corner forces that would change the sign of tractions,
        are no tractions of the basis: each node gets its share of them, over its length.
        """
        corners = self.corners
        forces, grip = corners.at_nodes(seen.forces), corners.at_nodes(seen.grip[None])[0]
        tractions = np.stack([self.tractions(force) for force in forces])
        pointed = corners.at_nodes(np.zeros_like(forces))
        taken = [k for moved in corners.moved for k in (moved.slot, moved.partner)]
        enough = seen.cover >= LEAST * self.full
        if len(taken) and (tractions[0, taken].min() < 0.0 or not enough[taken].all()):
            spread = seen.forces.copy()
            spread[:, [moved.slot for moved in corners.moved]] = 0.0
            tractions, pointed = np.stack([self.tractions(force) for force in spread]), forces - spread
        cover = seen.cover
        given, gap = self._of_points(multipliers)
        before = forces.copy()
        add(seen, forces, given, gap)
        pointed += forces - before
        bears = pointed.any(axis=0)
        tractions[:, bears & ~enough] = 0.0
        pointed[:, bears & ~enough] = forces[:, bears & ~enough]
        cover[bears] = np.where(enough, cover, np.where(cover > 0.0, LEAST, 1.0) * self.full)[bears]
        tractions[:, bears] += pointed[:, bears] / cover[bears]
        return ContactSnapshot(seen.at, seen.gaps, seen.normals, cover, grip, forces, tractions)

    def _of_points(self, multipliers: Floats) -> tuple[Floats, Floats]:
        """Return normal and tangential forces (2, k, 2) [N] of points at nodes with multipliers, and gaps (k,) [mm]."""
        points, given, gap = self.points, np.zeros((2, self.slots, 2)), np.zeros(self.slots)
        known = multipliers[:, points.own]
        for touch in points.touched:
            nodes = self.slave.segments[touch.segment]
            # opposite to the normal and the tangent of the point, whose slave is the master here
            for part, direction in enumerate((-touch.outward, touch.along)[: len(known)]):
                given[part, nodes] += known[part, touch.corner] * np.outer((1.0 - touch.xi, touch.xi), direction)
            gap[nodes] = points.gaps[touch.corner, 0]
        inner, *beside = self.between
        for values in given:
            for carriers in beside:
                np.add.at(values, carriers, 0.5 * values[inner])
            values[inner] = 0.0
        return given, gap
