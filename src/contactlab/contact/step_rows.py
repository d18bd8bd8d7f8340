"""Gaps and slips of a step as products of mid-step rows and its motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from contactlab.api import ContactDerivatives, Floats, Ints
from contactlab.contact.linearisation import Linearisation
from contactlab.contact.moment_free_rows import MomentFreeRows, neighbours
from contactlab.contact.start_gaps import FacetOverlap
from contactlab.kernels.contact.pair import FAR


class StepRows(Linearisation):
    """Mid-step rows G of the gaps of one pair, at predicted positions, and their constraints at the end of the step.

    The constraint is max(g_n, 0) + G (x - x_n) >= 0 from the start x_n with gaps g_n to the end x. The work of its
    forces is -y max(g_n, 0), never positive, however surfaces turn, slide or approach each other
    (docs/theory/contact-energy.md). Slips are R (x - x_n), R being mid-step tangents, and friction works
    y_t times the slip. The least change of G and R removes their moment about the mean positions, at which
    forces act: then angular momentum is kept.

    slots  (c,) multipliers with a constraint, held (c,) [mm] their max(g_n, 0)
    """

    def __init__(self, linear: Linearisation) -> None:
        nodes = linear.size // 2
        super().__init__(linear.pair, nodes)
        self.linear, self.memory, self.slots = linear, linear.memory, np.zeros(0, np.int32)
        self.gap, self.held, self.start = np.full(linear.pair.slots, FAR), np.zeros(0), np.zeros((nodes, 2))
        self.moved = np.zeros_like(self.start)
        sides = linear.pair.slave, linear.pair.master
        self.beside = neighbours([side.nodes[side.segments] for side in sides], nodes)
        self.normal = MomentFreeRows(csr_array((0, linear.size)), self.beside)
        self.tangent: MomentFreeRows | None = None

    def begin(self, time: float, position: Floats, middle: Floats) -> None:
        """Take the mid-step rows."""
        pair, linear = self.linear.pair, self.linear
        pair.update(position, self.memory)
        gap = pair.gaps[:, 0].copy()
        linear.evaluate(middle, position)
        # multipliers without a constraint at the start, or in the middle, can have no force
        self.present[:] = (pair.gaps[:, 0] < FAR) & (gap < FAR)
        self.slots = np.flatnonzero(self.present).astype(np.int32)
        self.normal = MomentFreeRows(linear.gap_derivatives(self.slots), self.beside)
        if pair.friction is not None:
            self.tangent = MomentFreeRows(linear.tangents(self.slots), self.beside)
        gap, facets = gap[self.slots], pair.start_gaps
        pushed = facets.pushed(time, float(facets.time[0])) if isinstance(facets, FacetOverlap) else None
        # gaps count as at the end of the step: overlaps by facets lose the share that begins to count
        less = 0.0 if pushed is None else pushed[self.slots]
        # pushing out initial overlaps adds energy on purpose
        self.held = gap if pair.pushes_overlaps_out else np.maximum(gap - less, 0.0) + less
        self.start = position.copy()
        self.gap[:], self.slip[:] = FAR, 0.0
        self.evaluate(position, position)

    def evaluate(self, position: Floats, start: Floats) -> None:
        """Compute the constrained values at the end, and slips of the step."""
        np.subtract(position, self.start, out=self.moved)
        self._about(self.start + 0.5 * self.moved)
        self.gap[self.slots] = self.held + self.normal.times(self.moved)
        if self.tangent is not None:
            self.slip[self.slots] = self.tangent.times(self.moved)

    def accept(self) -> None:
        """Update the pair's gaps to the end, by the mid-step rows."""
        self.linear.pair.compute_gaps(self.start + self.moved)

    def _about(self, position: Floats) -> None:
        for rows in (self.normal, self.tangent):
            if rows is not None:
                rows.about(position)

    def flexibilities(self, nodal: Floats) -> Floats:
        """Return mid-step flexibilities."""
        return self.linear.flexibilities(nodal)

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add rows times multipliers."""
        y = multipliers[:, self.pair.own][:, self.slots]
        normal += (self.normal.rows().T @ y[0]).reshape(-1, 2)
        if self.tangent is not None:
            tangential += (self.tangent.rows().T @ y[1]).reshape(-1, 2)

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Build derivatives from the change of rows with mean positions; each chosen multiplier has a constraint."""
        place = np.searchsorted(self.slots, chosen)
        force = self.normal.of_forces(y[0, self.slots])
        gap = self.normal.derivatives(self.moved)[place]
        if self.tangent is None:
            return ContactDerivatives(self.normal.rows()[place], None, gap, None, force)
        force = force + self.tangent.of_forces(y[1, self.slots])
        slip = self.tangent.derivatives(self.moved)[place]
        return ContactDerivatives(self.normal.rows()[place], self.tangent.rows()[place], gap, slip, force)

    def tangents(self, chosen: Ints) -> Any:
        """Return mid-step tangents."""
        return self.linear.tangents(chosen)

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return rows (c, 2N) of the chosen multipliers, normal and tangential (None without friction).

        They have no moment about the positions at the end.
        """
        place = np.searchsorted(self.slots, chosen)
        self._about(self.start + self.moved)
        normal = self.normal.rows()[place]
        tangent = None if self.tangent is None else self.tangent.rows()[place]
        self._about(self.start + 0.5 * self.moved)
        return normal, tangent
