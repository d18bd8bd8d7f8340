"""A pair with individual pressures at points: nodes get the means of their points."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, State
from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, ContactSnapshot, turned
from contactlab.kernels.contact.pair import FAR


class PointsPair(OperatorPair):
    """A slave and a master surface whose algorithm declares `points_press`.

    Reports show nodes. With the hats N_i and the weights w of the points with a constraint a node has the force
    sum of w N_i p n, the length sum of w N_i, and the quotient of both as its pressure: the integral of the pressures
    over these lengths is the force of the points. Gaps and slips are means with the same weights.
    """

    def snapshot(self, state: State, position: Floats) -> ContactSnapshot:
        """Return the snapshot by nodes: the first multiplier of each node represents all of them, others are open."""
        points = ContactPair.snapshot(self, state, position)
        slave, multiplier, share = self._shares()
        m, k = len(self.slave.nodes), self.slots
        cover = np.bincount(slave, share * self.cover[multiplier], m)
        along = turned(points.normals)
        force = [
            np.stack([np.bincount(slave, share * (y * vectors[:, c])[multiplier], m) for c in range(2)], axis=1)
            for y, vectors in zip(points.forces, (points.normals, along), strict=True)
        ]
        size = np.hypot(*force[0].T)
        mean = np.stack([np.bincount(slave, (share * points.normals[multiplier, c]), m) for c in range(2)], axis=1)
        pressed = np.asarray(size > 0.0)[:, None]
        normal = np.where(pressed, force[0], mean)
        normal = normal / np.maximum(np.hypot(*normal.T), 1e-300)[:, None]
        tangent = turned(normal)
        forces, normals, gaps, lengths = np.zeros((2, k)), np.zeros((k, 2)), np.full(k, FAR), np.zeros(k)
        forces[0, :m], forces[1, :m] = size, (force[1] * tangent).sum(axis=1)
        normals[:m], lengths[:m] = normal, cover
        gaps[:m] = np.where(cover > 0.0, self.at_nodes(points.gaps), FAR)
        tractions = np.divide(forces, lengths, out=np.zeros_like(forces), where=lengths > 0.0)
        return ContactSnapshot(points.at, gaps, normals, lengths, lengths, forces, tractions)

    @property
    def at_points(self) -> bool:
        """True: tractions of nodes are means over points."""
        return True

    def at_nodes(self, values: Floats) -> Floats:
        """Return means (m,) of values (k,) of the points at each node; 0 without points."""
        slave, multiplier, share = self._shares()
        weight, m = share * self.cover[multiplier], len(self.slave.nodes)
        total = np.bincount(slave, weight * values[multiplier], m)
        length = np.bincount(slave, weight, m)
        return np.asarray(np.divide(total, length, out=np.zeros(m), where=length > 0.0))

    def slips_at_nodes(self, slips: Floats, gaps: Floats) -> Floats:
        """Return means (m,) [mm] of the points' slips."""
        return self.at_nodes(slips)

    def facing(self) -> Ints:
        """Return the master segment (m,) in front of a point at each node; `NO_SEGMENT` without one."""
        found = np.full(len(self.slave.nodes), NO_SEGMENT, np.int32)
        segment = self.master.node_segments[self.pieces.master[: self.count, 0], 1]
        found[self.pieces.slave[: self.count]] = np.where(segment >= 0, segment, NO_SEGMENT)[:, None]
        return np.minimum(found, NO_SEGMENT)

    def _shares(self) -> tuple[Ints, Ints, Floats]:
        """Return slave node, multiplier, and value of the node's hat at the point, of all pieces."""
        pieces, count = self.pieces, self.count
        share = pieces.D[:count, :, 0] / pieces.T[:count, 0]
        multiplier = np.repeat(pieces.multiplier[:count, 0], share.shape[1])
        return pieces.slave[:count].ravel(), multiplier, share.ravel()
