"""Gaps and slips of a step as products of its motion and mid-step rows, whose forces have no moment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from contactlab.api import ContactDerivatives, Floats, Ints
from contactlab.api.arrays import Flags
from contactlab.contact.linearisation import Linearisation
from contactlab.contact.start_gaps import FacetOverlap
from contactlab.implicit.sparse import compressed, picked, product, rows_of, summed, total, transposed
from contactlab.kernels.contact.pair import FAR

AHEAD = 0.5  # share of the final motion that mean positions follow
PAIRED = 1e-6  # sum of a row over the sum of its absolute values: differences err by 1e-10, rows of one side alone by 1


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
        none = compressed(np.zeros(0), self.slots, np.zeros(1, np.int32), (0, linear.size))
        self.none = MomentFreeRows(none, self.beside, self.start)
        self.normal, self.tangent = self.none, None if linear.pair.friction is None else self.none

    def begin(self, time: float, position: Floats, middle: Floats) -> None:
        """Take the mid-step rows."""
        pair, linear = self.linear.pair, self.linear
        pair.update(position, self.memory)
        gap = pair.gaps[:, 0].copy()
        linear.evaluate(middle, position)
        # multipliers without a constraint at the start, or in the middle, can have no force
        self.present[:] = (pair.gaps[:, 0] < FAR) & (gap < FAR)
        self.slots = np.flatnonzero(self.present).astype(np.int32)
        self.normal = self._mid_step(linear.gap_derivatives, position)
        if pair.friction is not None:
            self.tangent = self._mid_step(linear.tangents, position)
        gap, facets = gap[self.slots], pair.start_gaps
        pushed = facets.pushed(time, float(facets.time[0])) if isinstance(facets, FacetOverlap) else None
        # gaps count as at the end of the step: overlaps by facets lose the share that begins to count
        less = 0.0 if pushed is None else pushed[self.slots]
        # pushing out initial overlaps adds energy on purpose
        self.held = gap if pair.pushes_overlaps_out else np.maximum(gap - less, 0.0) + less
        self.start, self.moved[:] = position.copy(), 0.0
        self.gap[:], self.slip[:] = FAR, 0.0
        self.gap[self.slots] = self.held

    def _mid_step(self, rows: Callable[[Ints], Any], position: Floats) -> MomentFreeRows:
        return MomentFreeRows(rows(self.slots), self.beside, position) if len(self.slots) else self.none

    def evaluate(self, position: Floats, start: Floats) -> None:
        """Compute the constrained values at the end, and slips of the step."""
        np.subtract(position, self.start, out=self.moved)
        if not len(self.slots):
            return
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
        if not len(self.slots):
            return
        y = multipliers[:, self.pair.own][:, self.slots]
        normal += self.normal.forces(y[0])
        if self.tangent is not None:
            tangential += self.tangent.forces(y[1])

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Build derivatives from the change of rows with mean positions; each chosen multiplier has a constraint."""
        place = np.searchsorted(self.slots, chosen).astype(np.int32)
        force = self.normal.of_forces(y[0, self.slots])
        normal, gap = self.normal.rows(place), self.normal.derivatives(self.moved, place)
        if self.tangent is None:
            return ContactDerivatives(normal, None, gap, None, force)
        force = total(force, self.tangent.of_forces(y[1, self.slots]))
        slip = self.tangent.derivatives(self.moved, place)
        return ContactDerivatives(normal, self.tangent.rows(place), gap, slip, force)

    def tangents(self, chosen: Ints) -> Any:
        """Return mid-step tangents."""
        return self.linear.tangents(chosen)

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return rows (c, 2N) of the chosen multipliers, normal and tangential (None without friction).

        They have no moment about the positions at the end.
        """
        place = np.searchsorted(self.slots, chosen).astype(np.int32)
        self._about(self.start + self.moved)
        normal = self.normal.rows(place)
        tangent = None if self.tangent is None else self.tangent.rows(place)
        self._about(self.start + 0.5 * self.moved)
        return normal, tangent


class MomentFreeRows:
    """The rows nearest to given rows, in the sum of squares, whose forces have no moment about given positions.

    A row of forces g_i on nodes at x_i, whose sum is zero, has the moment m = sum r_i x g_i, r_i = x_i - c, c being the
    mean of the x_i. Without it, by the least change of its entries (Z is a quarter turn),

        g'_i = g_i - L Z r_i,    L = m / S,    S = sum |r_i|^2

    and its sum is still zero. Like x_i, g'_i change with the positions that a step leads to. Errors of differences in
    a sum are removed as well; rows with a sum of their own, which push one side alone, stay as they are.

    given   (c, 2N) rows, CSR
    beside  (N, N) nodes that take part in the change of a row with an entry for one of them: its neighbours on
            its surface, as coincident nodes have no arm to turn about
    position  (N, 2) where the moment vanishes, until `about` is called
    """

    def __init__(self, given: Any, beside: Any, position: Floats) -> None:
        self.shape = given.shape
        nodes, row, (node, component) = (
            given.shape[1] // 2,
            rows_of(given).astype(np.int64),
            np.divmod(given.indices, 2),
        )
        of = product(summed(row, node, np.ones(len(row)), (self.shape[0], nodes)), beside)
        known = np.sort(rows_of(of).astype(np.int64) * nodes + of.indices)
        self.row, self.node = np.divmod(known, nodes)
        place = 2 * np.searchsorted(known, row * nodes + node) + component
        self.given = np.asarray(np.bincount(place, given.data, 2 * len(known)), np.float64).reshape(-1, 2)
        count = np.diff(of.indptr)
        self.count = np.maximum(count, 1)
        self.start = np.append(0, 2 * np.cumsum(count))
        self.column, self.places = (
            np.add.outer(2 * of, [0, 1]).ravel().astype(np.int32) for of in (self.node, self.row)
        )
        # remainders of the sums of rows that push both sides are removed
        size = self._sum(np.abs(self.given).sum(axis=1))
        left = self._sums(self.given)
        paired: Flags = np.abs(left).max(axis=1, initial=0.0) <= PAIRED * size
        self.given -= np.where(paired[:, None], left / self.count[:, None], 0.0)[self.row]
        self.paired = paired
        self.about(position)

    def about(self, position: Floats) -> None:
        """Make the moment about `position` (N, 2) vanish."""
        self.arm = self._from_mean(position[self.node])
        self.spread = np.where(self.paired, self._sum((self.arm**2).sum(axis=1)), 0.0)
        moment = self._sum(self.arm[:, 0] * self.given[:, 1] - self.arm[:, 1] * self.given[:, 0])
        self.share = np.divide(moment, self.spread, out=np.zeros_like(moment), where=self.spread > 0.0)
        self.turned = _turned(self.arm)
        self.values = self.given - self.share[self.row, None] * self.turned

    def rows(self, at: Ints) -> Any:
        """Return the rows `at` (2N columns), in ascending order."""
        return self._picked(self.values, at)

    def forces(self, multipliers: Floats) -> Floats:
        """Return the nodal forces (N, 2) of `multipliers` (c,)."""
        values = self.values * multipliers[self.row, None]
        return np.asarray(np.bincount(self.column, values.ravel(), self.shape[1]), np.float64).reshape(-1, 2)

    def times(self, motion: Floats) -> Floats:
        """Return the rows (c,) times a motion (N, 2)."""
        return self._sum((self.values * motion[self.node]).sum(axis=1))

    def derivatives(self, motion: Floats, at: Ints) -> Any:
        """Return derivatives of the values `at` of `times`, as `motion` (N, 2) grows and mean positions follow it."""
        of_share = self._of_share()
        moved = motion[self.node]
        turned = self._sum((self.turned * moved).sum(axis=1))
        # sum Z dr_i . w_i = - sum dr_i . Z w_i
        swept = AHEAD * self.share[self.row, None] * _turned(self._from_mean(moved))
        return self._picked(self.values - turned[self.row, None] * of_share + swept, at)

    def of_forces(self, multipliers: Floats) -> Any:
        """Return the derivative (2N, 2N) of the forces of `multipliers` (c,), as mean positions follow the nodes.

        Without the derivative of the arms r, which belongs to the small L.
        """
        arms = self._matrix(-multipliers[self.row, None] * self.turned)
        return product(transposed(arms), self._matrix(self._of_share()))

    def _of_share(self) -> Floats:
        """Return derivatives (z, 2) of L: dL = (dm - L dS) / S."""
        grown = -_turned(self.given) - 2.0 * self.share[self.row, None] * self.arm
        spread = self.spread[self.row, None]
        return AHEAD * np.divide(grown, spread, out=np.zeros_like(grown), where=spread > 0.0)

    def _from_mean(self, values: Floats) -> Floats:
        """Return values (z, 2) less their mean in each row."""
        mean: Floats = (self._sums(values) / self.count[:, None])[self.row]
        return values - mean

    def _sum(self, values: Floats) -> Floats:
        return np.asarray(np.bincount(self.row, values, self.shape[0]), np.float64)

    def _sums(self, vectors: Floats) -> Floats:
        sums = np.bincount(self.places, vectors.ravel(), 2 * self.shape[0]).reshape(-1, 2)
        return np.asarray(sums, np.float64)

    def _picked(self, values: Floats, at: Ints) -> Any:
        return picked(self._matrix(values), at)

    def _matrix(self, values: Floats) -> Any:
        return compressed(values.ravel(), self.column, self.start, self.shape)


def _turned(vectors: Floats) -> Floats:
    """Return vectors (z, 2) after a quarter turn from x to y."""
    turned: Floats = vectors[:, ::-1] * (-1.0, 1.0)
    return turned


def neighbours(segments: Sequence[Ints], nodes: int) -> Any:
    """Return (N, N) nodes with a common segment of some surfaces, each (s, a) global node numbers, and single nodes."""
    parts = [np.repeat(np.arange(nodes)[:, None], 2, axis=1)]
    for surface in segments:
        along = surface.shape[1]
        parts.append(
            np.stack([np.repeat(surface, along, axis=1).ravel(), np.tile(surface, (1, along)).ravel()], axis=1)
        )
    pairs = np.concatenate(parts)
    return summed(pairs[:, 0], pairs[:, 1], np.ones(len(pairs)), (nodes, nodes))
