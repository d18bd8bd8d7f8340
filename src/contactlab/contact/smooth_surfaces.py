"""Smooth surfaces of a pair: gaps between curves through the nodes instead of their segments.

Multipliers, forces and search stay on segments; `contactlab.kernels.contact.smooth` has the curves.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats, Ints, SegmentContact, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.contact.linearisation import triplets
from contactlab.contact.operator_pair import OperatorPair
from contactlab.formulas import segments
from contactlab.kernels.contact import smooth as kernels

SMOOTH = np.cos(0.6)  # cosine of the largest angle (34 degrees) between segments of one curve, as in `results.facets`
ENTRIES = 224  # of derivatives for each piece: 128 of bends, 96 of moments


class SmoothSurfaces:
    """Curves through the nodes of both sides of a pair, and their contribution to its gaps.

    reference  (N, 2) [mm] positions at which corners are found
    """

    def __init__(self, pair: OperatorPair, reference: Floats) -> None:
        assert isinstance(pair.algorithm, SegmentContact)
        self.pair, self.part = pair, pair.algorithm
        sides = pair.slave, pair.master
        self.sides = tuple(
            (side.segments, _beside(side, reference[side.nodes]), np.zeros((len(side.segments), 4))) for side in sides
        )
        self.moments, self.shift = np.zeros((0, 4, 2)), np.zeros((pair.slots, 2))
        self.nodes = np.concatenate([side.nodes for side in sides])

    def update(self, memory: Floats) -> None:
        """Integrate over the pieces of the last update of the pair."""
        pieces = self.pair.pieces
        if len(self.moments) < len(pieces.slave):
            self.moments = np.zeros((len(pieces.slave), 4, 2))
        segments.moments(self.part, self.pair.seen(memory), pieces, self.pair.count, self.moments)

    def shifts(self, at: SurfacePositions) -> Floats:
        """Return the shift of separations (k, 2) [mm] by curves at positions `at`, valid until the next call."""
        pair, shift = self.pair, self.shift
        places, moments = pair.pieces.segment, self.moments
        kernels.shifts(pair.address, pair.count, tuple(at), self.sides, places, moments, shift)
        return shift

    def add(self, at: SurfacePositions, gaps: Floats) -> None:
        """Add the offset of the curves from the segments at positions `at` to normal gaps (k, 2) [mm]."""
        kernels.add_normal(self.shifts(at), self.pair.normals, gaps)

    def derivatives(self, memory: Floats) -> tuple[Ints, Ints, Floats]:
        """Return entries of the derivatives of separations by nodes through the curves, before T.

        Rows are 2 k + component, columns as in the model.
        """
        pair, pieces, owner, at = self.pair, self.pair.pieces, self.pair.coupling.owner, tuple(self.pair.at)
        out = row, column, value = triplets(ENTRIES * pair.count)
        kernels.put_all_bends(at, self.sides)
        bends = self.sides[0][2], self.sides[1][2]
        count = segments.moment_derivatives(
            self.part, pair.seen(memory), pieces, pair.count, owner, bends, self.nodes, out
        )
        sides = tuple(
            (*side[:2], surface.nodes, np.zeros((len(side[0]), 4, 8)))
            for side, surface in zip(self.sides, (pair.slave, pair.master), strict=True)
        )
        rest = row[count:], column[count:], value[count:]
        count += kernels.bend_derivatives(
            pair.count, pieces.multiplier, owner, pieces.segment, self.moments, at, sides, rest
        )
        return row[:count], column[:count], value[:count]


def _beside(surface: Surface, at: Floats) -> Ints:
    """Return segments (s, 2) before and after each on the same curve, -1 at ends of curves."""
    edges: Any = at[surface.segments[:, 1]] - at[surface.segments[:, 0]]
    along = edges / np.hypot(*edges.T)[:, None]
    beside = np.stack([surface.node_segments[surface.segments[:, end], end] for end in range(2)], axis=1)
    turn = np.einsum("sci,si->sc", along[beside], along)
    return np.where((beside >= 0) & (turn >= SMOOTH), beside, -1).astype(np.int32)
