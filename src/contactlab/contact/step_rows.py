"""Gaps and slips of a step as products of rows and its motion, rows that belong to its middle."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from contactlab.api import Floats, Ints
from contactlab.api.arrays import Flags
from contactlab.contact.gap_linearisation import GapLinearisation
from contactlab.contact.linearisation import PairDerivatives, PairLinearisation
from contactlab.contact.moment_free_rows import MomentFreeRows, neighbours
from contactlab.contact.start_gaps import FacetOverlap
from contactlab.kernels.contact.factored_rows import FAR


class StepRows:
    """Rows G of the gaps of one pair in the middle of a step, as its velocities predict it, and what holds at its end.

    That is max(g_n, 0) + G (x - x_n) >= 0 from the start x_n, where gaps are g_n, to the end x. The work of forces that
    hold it is -y max(g_n, 0), never positive, however surfaces turn, slide or come within reach of each other
    (docs/theory/contact-energy.md). With friction slips are R (x - x_n), R being tangents there, and friction works
    y_t times that. G and R are changed by as little as it takes to have no moment about the mean positions, with which
    forces act: then angular momentum is kept.

    slots  (c,) multipliers that have a condition
    """

    def __init__(self, linear: PairLinearisation | GapLinearisation) -> None:
        self.linear, self.slots = linear, np.zeros(0, np.int32)
        self.gap, self.start = np.zeros(0), np.zeros((linear.size // 2, 2))
        self.moved = np.zeros_like(self.start)
        sides = linear.pair.slave, linear.pair.master
        self.beside = neighbours([side.nodes[side.segments] for side in sides], len(self.start))
        self.normal = MomentFreeRows(csr_array((0, linear.size)), self.beside)
        self.tangent: MomentFreeRows | None = None

    def begin(self, begun: float, position: Floats, middle: Floats, memory: Floats) -> None:
        """A step starts at the time `begun` [s] at `position` (N, 2) and leads by way of `middle`."""
        pair, linear = self.linear.pair, self.linear
        pair.update(position, memory)
        gap = pair.gaps[:, 0].copy()
        linear.evaluate(middle, position, memory)
        self.slots = np.flatnonzero((pair.gaps[:, 0] < FAR) & (gap < FAR)).astype(np.int32)
        self.normal = MomentFreeRows(linear.gap_derivatives(self.slots, memory), self.beside)
        if pair.friction is not None:
            self.tangent = MomentFreeRows(linear.tangents(self.slots), self.beside)
        gap, facets = gap[self.slots], pair.start_gaps
        pushed = facets.pushed(begun, float(facets.time[0])) if isinstance(facets, FacetOverlap) else None
        # gaps are those that count at the end of the step: of overlaps by facets, what comes to count in it goes
        less = 0.0 if pushed is None else pushed[self.slots]
        # overlaps of the start that are pushed out put energy in on purpose
        self.gap = gap if pair.pushes_overlaps_out else np.maximum(gap - less, 0.0) + less
        self.start = position.copy()
        self.move(position)

    def move(self, position: Floats) -> None:
        """The step ends at `position` (N, 2)."""
        np.subtract(position, self.start, out=self.moved)
        self._about(self.start + 0.5 * self.moved)

    def _about(self, position: Floats) -> None:
        for rows in (self.normal, self.tangent):
            if rows is not None:
                rows.about(position)

    @property
    def present(self) -> Flags:
        """Which multipliers (k,) have a condition: others, which had one a step before, can have no force."""
        found = np.zeros(self.linear.pair.slots, np.bool_)
        found[self.slots] = True
        return found

    def gaps(self) -> Floats:
        """What is to be no less than zero (k,) [mm] at the end; `FAR` without a condition."""
        out = np.full(self.linear.pair.slots, FAR)
        out[self.slots] = self.gap + self.normal.times(self.moved)
        return out

    def slips(self) -> Floats:
        """Slips (k,) [mm] of the step; none without friction."""
        out = np.zeros(self.linear.pair.slots)
        if self.tangent is not None:
            out[self.slots] = self.tangent.times(self.moved)
        return out

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add the nodal forces of the pair's multipliers (r, k) [N] to (N, 2) each."""
        normal += (self.normal.rows().T @ multipliers[0, self.slots]).reshape(-1, 2)
        if self.tangent is not None:
            tangential += (self.tangent.rows().T @ multipliers[1, self.slots]).reshape(-1, 2)

    def linearise(self, chosen: Ints, multipliers: Floats) -> PairDerivatives:
        """Derivatives of the chosen multipliers, each of which has a condition, where all have forces y (r, k) [N]."""
        place = np.searchsorted(self.slots, chosen)
        force = self.normal.of_forces(multipliers[0, self.slots])
        gap = self.normal.derivatives(self.moved)[place]
        if self.tangent is None:
            return PairDerivatives(self.normal.rows()[place], None, gap, None, force)
        force = force + self.tangent.of_forces(multipliers[1, self.slots])
        slip = self.tangent.derivatives(self.moved)[place]
        return PairDerivatives(self.normal.rows()[place], self.tangent.rows()[place], gap, slip, force)

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Rows (c, 2N) of the chosen multipliers, normal and tangential ones (None without friction).

        They have no moment about the positions at the end.
        """
        place = np.searchsorted(self.slots, chosen)
        self._about(self.start + self.moved)
        normal = self.normal.rows()[place]
        tangent = None if self.tangent is None else self.tangent.rows()[place]
        self._about(self.start + 0.5 * self.moved)
        return normal, tangent
