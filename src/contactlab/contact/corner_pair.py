"""Corners of the master as points that stay outside the slave, a pair next to a mortar pair, with exchanged sides."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from contactlab.api import ContactView, Floats, GapAlgorithm, GapConditions
from contactlab.api.surface import SurfacePositions
from contactlab.contact.corners import Corners, Touch
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.pair import turned
from contactlab.kernels.contact.search import take

POINT = 1e-6  # of a segment: the length of a point, so that adhesion and shear bounds are negligible


class CornerPoints(GapAlgorithm):
    """The method of a pair whose constraints follow from another pair."""

    passes_patch_test: ClassVar[bool] = False

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        """Raise NotImplementedError: the pair of the mortar finds the constraints."""
        raise NotImplementedError("points at corners are found by the pair of the mortar")


class CornerPair(GapPair):
    """Constraints of the `corners.points`: gaps to a segment, whose weights are their derivatives.

    corners  corners of the mortar pair, which is updated first
    touched  their contacts, in the order of the constraints
    """

    at_corners: ClassVar[bool] = True
    corners: Corners
    touched: tuple[Touch, ...] = ()
    idle = False

    def calls_per_step(self) -> dict[str, int]:
        """Return an empty count: no algorithm is called."""
        return {}

    def update(self, positions: Floats, memory: Floats) -> None:
        """Make the constraints at `positions` (N, 2) of the corners that are points of the mortar's last update."""
        if self.idle and not self.corners.points:
            return
        chosen = {touch.corner for touch in self.corners.points}
        take(positions, self.slave.nodes, self.at.slave)
        take(positions, self.master.nodes, self.at.master)
        at = SurfacePositions(self.at.master, self.at.slave)
        self.touched = tuple(touch for touch in self.corners.touches(at) if touch.corner in chosen)
        self.idle = not self.touched
        found = self.found = self._conditions()
        self.made_at[:] = positions
        self.cover[:] = 0.0
        self.cover[found.owner] = found.measure
        self.full[found.owner] = [touch.length for touch in self.touched]
        self.normals[found.owner] = np.array([touch.outward for touch in self.touched]).reshape(-1, 2)
        self.compute_gaps(positions)

    def update_pushed(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """Update unless idle without points at corners."""
        if not self.idle or self.corners.points:
            super().update_pushed(predicted, compliance, force, memory)

    def _conditions(self) -> GapConditions:
        k = len(self.touched)
        node, weight = np.zeros((k, 3), np.int32), np.zeros((k, 3, 2))
        gap, measure, owner = np.zeros(k), np.zeros(k), np.zeros(k, np.int32)
        for c, touch in enumerate(self.touched):
            node[c] = self.slave.nodes[touch.corner], *self.master.nodes[self.master.segments[touch.segment]]
            weight[c] = np.outer((1.0, touch.xi - 1.0, -touch.xi), touch.outward)
            gap[c] = touch.gap + self.corners.depth[touch.corner]
            measure[c], owner[c] = POINT * touch.length, touch.corner
        normal, start = weight.reshape(-1, 2), np.arange(0, 3 * k + 1, 3, dtype=np.int32)
        along = turned(normal) if self.friction is not None else np.zeros((0, 2))
        return GapConditions(start, node.ravel(), normal, along, gap, measure, owner)

    def compute_start_normals(self, positions: Floats, memory: Floats) -> None:
        """Compute normals of the same segments at `positions`, the start of the step."""
        assert self.sliding is not None
        self.sliding.before[:] = self.normals
        for touch in self.touched:
            a, b = positions[self.master.nodes[self.master.segments[touch.segment]]]
            x, y = (b - a) / np.hypot(*(b - a))
            self.sliding.before[touch.corner] = y, -x
