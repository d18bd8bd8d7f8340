"""A pair with smooth surfaces: gaps between curves through the nodes instead of their segments.

Multipliers, forces and search stay on segments; `contactlab.kernels.contact.smooth` has the curves.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from contactlab.api import ContactView, Floats, Ints, SegmentContact, Surface
from contactlab.api.derivatives import PieceDerivatives
from contactlab.api.surface import SurfacePositions
from contactlab.contact.linearisation import Entries, PairLinearisation, Parts, spread, triplets
from contactlab.contact.operator_pair import OperatorPair
from contactlab.formulas import segments
from contactlab.kernels.contact import smooth as kernels

SMOOTH = np.cos(0.6)  # cosine of the largest angle (34 degrees) between segments of one curve, as in `results.facets`
ENTRIES = 224  # of derivatives for each piece: 128 of bends, 96 of moments


class SmoothPair(OperatorPair):
    """A slave and a master surface with curves through the nodes of both, whose corners are found at `reference`."""

    smooth: ClassVar[bool] = True

    def _prepare(self, reference: Floats) -> None:
        assert isinstance(self.algorithm, SegmentContact)
        self.part = self.algorithm
        self.curves = tuple(
            (side.segments, _beside(side, reference[side.nodes]), np.zeros((len(side.segments), 4)))
            for side in (self.slave, self.master)
        )
        self.moments, self.shift = np.zeros((0, 4, 2)), np.zeros((self.slots, 2))

    def _join(self, view: ContactView) -> None:
        """Compute what every pair does, integrate over the pieces, and measure gaps between the curves."""
        super()._join(view)
        if len(self.moments) < len(self.pieces.slave):
            self.moments = np.zeros((len(self.pieces.slave), 4, 2))
        segments.moments(self.part, view, self.pieces, self.count, self.moments)
        kernels.add_normal(self.shifts(self.measured), self.normals, self.gaps)

    def gaps_at(self, positions: Floats) -> Floats:
        """Return gaps (k, 2) between the curves at `positions`, with the rows of the last `update`, in a new array."""
        gaps = super().gaps_at(positions)
        at = SurfacePositions(positions[self.slave.nodes], positions[self.master.nodes])
        kernels.add_normal(self.shifts(at), self.normals, gaps)
        return gaps

    def shifts(self, at: SurfacePositions) -> Floats:
        """Return the shift of separations (k, 2) [mm] by curves at positions `at`, valid until the next call."""
        kernels.shifts(self.address, self.count, tuple(at), self.curves, self.pieces.segment, self.moments, self.shift)
        return self.shift

    def shift_derivatives(self, memory: Floats) -> Entries:
        """Return entries of the derivatives of separations by nodes through the curves, before T.

        Rows are 2 k + component, columns as in the model.
        """
        pieces, owner, at = self.pieces, self.coupling.owner, tuple(self.at)
        out = row, column, value = triplets(ENTRIES * self.count)
        kernels.put_all_bends(at, self.curves)
        bends = self.curves[0][2], self.curves[1][2]
        nodes = np.concatenate([self.slave.nodes, self.master.nodes])
        count = segments.moment_derivatives(self.part, self.seen(memory), pieces, self.count, owner, bends, nodes, out)
        sides = tuple(
            (*side[:2], surface.nodes, np.zeros((len(side[0]), 4, 8)))
            for side, surface in zip(self.curves, (self.slave, self.master), strict=True)
        )
        rest = row[count:], column[count:], value[count:]
        count += kernels.bend_derivatives(
            self.count, pieces.multiplier, owner, pieces.segment, self.moments, at, sides, rest
        )
        return row[:count], column[:count], value[:count]


class SmoothLinearisation(PairLinearisation):
    """`PairLinearisation` of a pair whose gaps gain nu . c, c = T^-T C, which changes with nu, T and C."""

    pair: SmoothPair

    def _parts(
        self, chosen: Ints, directions: list[Floats], inverse: Entries, pieces: PieceDerivatives, wanted: Floats
    ) -> Parts:
        parts, changes = super()._parts(chosen, directions, inverse, pieces, wanted)
        pair, own = self.pair, (chosen, chosen, np.ones(len(chosen)))
        shift, nowhere = pair.shifts(pair.at), SurfacePositions(*(np.zeros_like(at) for at in pair.at))
        parts[0, 1] = spread(own, pair.separation + shift)
        for more in (self._weight_changes(pieces, wanted, nowhere, shift), pair.shift_derivatives(self.memory)):
            parts[0, len(changes)] = parts[0, 0]
            changes.append(more)
        return parts, changes


def _beside(surface: Surface, at: Floats) -> Ints:
    """Return segments (s, 2) before and after each on the same curve, -1 at ends of curves."""
    edges: Any = at[surface.segments[:, 1]] - at[surface.segments[:, 0]]
    along = edges / np.hypot(*edges.T)[:, None]
    beside = np.stack([surface.node_segments[surface.segments[:, end], end] for end in range(2)], axis=1)
    turn = np.einsum("sci,si->sc", along[beside], along)
    return np.where((beside >= 0) & (turn >= SMOOTH), beside, -1).astype(np.int32)
