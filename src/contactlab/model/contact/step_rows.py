"""Gaps of a step as linear functions of its motion, by their derivatives in its middle."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from contactlab.api import Floats, Ints
from contactlab.kernels.contact.factored_rows import FAR
from contactlab.model.contact.linearisation import PairDerivatives, PairLinearisation


class StepRows:
    """Rows G of one pair in the middle of a step, as its velocities predict it; what has to hold at its end x.

    That is max(g_n, 0) + G (x - x_n) >= 0, g_n being the gap at the start x_n. The work of forces that hold it is
    -y max(g_n, 0), never positive, however surfaces turn, slide or come within reach of each other
    (docs/theory/contact-energy.md). In the middle G has no moment about the mean positions, with which forces act.

    slots  (c,) multipliers that have a condition
    rows   (c, 2N) derivatives of their gaps
    """

    def __init__(self, linear: PairLinearisation) -> None:
        self.linear, self.slots = linear, np.zeros(0, np.int32)
        self.gap, self.start = np.zeros(0), np.zeros(0)
        self.rows: Any = csr_array((0, linear.size))

    def begin(self, position: Floats, middle: Floats, memory: Floats) -> None:
        """A step starts at `position` (N, 2) and leads by way of `middle`."""
        pair = self.linear.pair
        pair.update(position, memory)
        gap = pair.gaps[:, 0].copy()
        pair.update(middle, memory)
        self.slots = np.flatnonzero((pair.gaps[:, 0] < FAR) & (gap < FAR)).astype(np.int32)
        self.rows = self.linear.gap_derivatives(self.slots, memory)
        gap = gap[self.slots]
        # overlaps of the start that are pushed out put energy in on purpose
        self.gap, self.start = gap if pair.pushes_overlaps_out else np.maximum(gap, 0.0), position.ravel().copy()

    def gaps(self, position: Floats) -> Floats:
        """What is to be no less than zero (k,) [mm] at `position` (N, 2); `FAR` without a condition."""
        out = np.full(self.linear.pair.slots, FAR)
        out[self.slots] = self.gap + self.rows @ (position.ravel() - self.start)
        return out

    def forces(self, multipliers: Floats) -> Floats:
        """Nodal forces (N, 2) [N] of the pair's multipliers (k,)."""
        return np.asarray(self.rows.T @ multipliers[self.slots]).reshape(-1, 2)

    def linearise(self, chosen: Ints) -> PairDerivatives:
        """Derivatives of the chosen multipliers, each of which has a condition: constant in a step."""
        rows = self.rows[np.searchsorted(self.slots, chosen)]
        return PairDerivatives(rows, None, rows, None, csr_array((self.linear.size, self.linear.size)))
