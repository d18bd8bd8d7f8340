"""Derivatives of the gaps, slips and nodal forces of one contact pair by the positions of its nodes.

With tractions a = T^-1 q, nodal forces are D a and -M a; separations are r = T^-T (D^T x - M^T y), gaps
g = nu . r. Their derivatives need only those D, M, T and nu, which are local to an integration segment:

    d r = P dx + T^-T (dD^T x - dM^T y - dT^T r)            P = T^-T [D^T | -M^T]
    d f = [dD; -dM] a + P^T (dq - dT a)                      q = y_n nu + y_t tau
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_array, csr_array

from contactlab.api import ContactDerivatives, Floats, Ints
from contactlab.api.derivatives import PieceDerivatives
from contactlab.api.surface import SurfacePositions
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, turned
from contactlab.kernels.contact import banded_rows
from contactlab.kernels.contact import linearisation as kernels
from contactlab.kernels.contact.pair import BandedRows

if TYPE_CHECKING:
    from contactlab.contact.smooth_surfaces import SmoothSurfaces

CUT = 1e-13  # weights below it move gaps by less than round-off: linear problems end after one iteration


class Linearisation(ABC):
    """Gaps, slips and nodal forces of one pair at trial positions, and their derivatives there.

    memory   memory of the algorithm since the start of the step
    present  (k,) multipliers that may have a constraint
    gap      (k,) [mm] `FAR` without a constraint
    slip     (k,) [mm] since the last accepted step; (0,) without friction
    size     2N degrees of freedom
    """

    pair: ContactPair

    def __init__(self, pair: Any, nodes: int) -> None:
        self.pair, self.size, k = pair, 2 * nodes, pair.slots
        self.memory = np.zeros((pair.method.memory_size, len(pair.slave.nodes)))
        self.present, self.gap = np.ones(k, np.bool_), pair.gaps[:, 0]
        self.slip = np.zeros(k if pair.friction is not None else 0)

    def begin(self, time: float, position: Floats, middle: Floats) -> None:  # noqa: B027 - most need no beginning
        """Begin a step at `time` [s] from `position` (N, 2), by way of `middle`."""

    @abstractmethod
    def evaluate(self, position: Floats, start: Floats) -> None:
        """Compute gaps of the pair, and slips since the positions `start` (N, 2) of the last accepted step."""

    def accept(self) -> None:  # noqa: B027 - nor an end
        """End the step at its last evaluation."""

    @abstractmethod
    def flexibilities(self, nodal: Floats) -> Floats:
        """Return displacement (k,) [mm/N] of each constraint per unit force, from nodal flexibilities (N, 2)."""

    @abstractmethod
    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add the nodal forces of the model's multipliers to (N, 2) each; the second is (0, 2) without friction."""

    @abstractmethod
    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Return derivatives of the `chosen` multipliers (c,) with forces y (r, k) [N] on all.

        Without forces, r = 0, `force` is None.
        """

    def gap_derivatives(self, chosen: Ints) -> Any:
        """Return derivatives (c, 2N) of the gaps of the chosen multipliers alone."""
        return self.linearise(chosen, np.zeros((0, self.pair.slots))).gap

    @abstractmethod
    def tangents(self, chosen: Ints) -> Any:
        """Return friction directions (c, 2N) of the chosen multipliers."""


def linearised(pair: ContactPair, nodes: int, consistent: bool = False, whole_steps: bool = False) -> Linearisation:
    """Return the linearisation of a pair at trial positions, in a model of `nodes` nodes.

    consistent  normal forces act along the derivatives of the gaps; whole_steps: by rows of a whole step
    """
    if not isinstance(pair, OperatorPair):
        from contactlab.contact.gap_linearisation import linearised_gaps

        found: Linearisation = linearised_gaps(pair, nodes)
    elif pair.half:
        from contactlab.contact.half_passes import HalfPassLinearisation

        found = HalfPassLinearisation(pair, nodes)
    else:
        found = (ConsistentLinearisation if consistent and not whole_steps else PairLinearisation)(pair, nodes)
        if pair.corners is not None:
            from contactlab.contact.taken_linearisation import TakenLinearisation

            found = TakenLinearisation(found, pair.corners)
    if whole_steps:
        from contactlab.contact.step_rows import StepRows

        return StepRows(found)
    return found


class PairLinearisation(Linearisation):
    """Linearisation of a pair whose algorithm gives operators, with forces along weights and frozen normals."""

    pair: OperatorPair

    def __init__(self, pair: OperatorPair, nodes: int) -> None:
        super().__init__(pair, nodes)
        k = pair.slots
        self.inverse = BandedRows.allocate(k, 16)
        self.start_separation, self.start_gaps = np.zeros((k, 2)), np.zeros((k, 2))

    def evaluate(self, position: Floats, start: Floats) -> None:
        """Update the pair at `position`."""
        pair = self.pair
        pair.update(position, self.memory)
        sliding = pair.sliding
        if sliding is None:
            return
        pair.compute_start_normals(start, self.memory)
        # summed as the pair's own gaps are, so that a surface that has not moved has not slipped, to the last bit
        pair.separations(sliding.began, sliding.before, self.start_separation, self.start_gaps)
        np.subtract(pair.gaps[:, 1], self.start_gaps[:, 1], out=self.slip)

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Sum derivatives of integration segments, spread by T^-T."""
        pair, pieces = self.pair, self.pair.derivatives(self.memory)
        y_n, y_t = parts_of(y, pair)
        normal, tangent = pair.normals, turned(pair.normals)
        traction = self._tractions(y_n, y_t)
        # the chosen rows of T^-T
        self.inverse = banded_rows.inverse_rows(pair.coupling, self.inverse)
        inverse = entries(chosen, self.inverse, CUT)
        size = np.hypot(*traction.T)
        wanted = size > CUT * max(float(size.max(initial=0.0)), 1e-300)
        wanted[inverse[1]] = True
        weights = self._weights(np.flatnonzero(wanted).astype(np.int32))
        dnormal = self._turned_normals(pieces, pieces.dnormal[: pieces.normal_count])
        dweight = self._gap_derivatives(pieces, wanted, pair.at, pair.separation)
        gap = self._along(chosen, normal, inverse, weights, dweight) + self._rows(chosen, pair.separation) @ dnormal
        if pair.smooth is not None:
            gap = gap + self._by_curves(pair.smooth, chosen, inverse, pieces, wanted, dnormal)
        force = self._force_derivative(pieces, wanted, traction, weights, y_n, y_t) if len(y) else None
        if y_t is None:
            return ContactDerivatives(self._rows(chosen, normal) @ weights, None, gap, None, force)
        # tau . r = nu . (r turned by +90 degrees)
        slip = self._along(chosen, tangent, inverse, weights, dweight)
        slip = slip - self._rows(chosen, turned(pair.separation)) @ dnormal
        assert pair.sliding is not None
        began = self._gap_derivatives(pieces, wanted, pair.sliding.began, self.start_separation)
        slip = slip - self._spread(chosen, turned(pair.sliding.before), inverse) @ began
        return ContactDerivatives(
            self._rows(chosen, normal) @ weights, self._rows(chosen, tangent) @ weights, gap, slip, force
        )

    def tangents(self, chosen: Ints) -> Any:
        """Return weights times tangents."""
        return self._rows(chosen, turned(self.pair.normals)) @ self._weights(chosen)

    def flexibilities(self, nodal: Floats) -> Floats:
        """Sum squared weights."""
        out = np.zeros(self.pair.slots)
        self.pair.weights()
        kernels.flexibilities(self.pair.address, nodal, out)
        return out

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add weights times multipliers."""
        self.pair.weights()
        kernels.add_forces(self.pair.address, multipliers, self.pair.first_slot, normal, tangential)

    # --- the pair's own operators -----------------------------------------------------------------

    def _tractions(self, y_n: Floats, y_t: Floats | None) -> Floats:
        """Return a = T^-1 q (k, 2) of the kept multipliers, zero elsewhere."""
        pair, normal = self.pair, self.pair.normals
        q = y_n[:, None] * normal
        if y_t is not None:
            q += y_t[:, None] * turned(normal)
        out, kept = np.zeros_like(q), pair.coupling.order
        for c in range(2):
            out[kept, c] = pair.coupling.solve(q[:, c])[kept]
        return out

    def _weights(self, chosen: Ints) -> Any:
        """Return rows 2 k + component of P by all degrees of freedom, for the chosen multipliers."""
        pair, parts = self.pair, []
        sides, numbered = pair.weights(), (pair.slave.nodes, pair.master.nodes)
        for side, numbers, sign in zip(sides, numbered, (1.0, -1.0), strict=True):
            row, column, value = entries(chosen, side, CUT)
            parts.append((row, numbers[column], sign * value))
        row, column, value = (np.concatenate(part) for part in zip(*parts, strict=True))
        return self._matrix(_both(row), _both(column), np.repeat(value, 2), 2 * pair.slots)

    def _along(self, chosen: Ints, direction: Floats, inverse: Any, weights: Any, dweight: Any) -> Any:
        """Return direction . (P + T^-T dweight), one row for each chosen multiplier."""
        return self._rows(chosen, direction) @ weights + self._spread(chosen, direction, inverse) @ dweight

    def _rows(self, chosen: Ints, vectors: Floats) -> Any:
        """Return (c, 2k): row i has the two components of vectors[chosen[i]] at its own place."""
        start = np.arange(0, 2 * len(chosen) + 1, 2)
        return csr_array((vectors[chosen].ravel(), _both(chosen), start), shape=(len(chosen), 2 * self.pair.slots))

    def _spread(self, chosen: Ints, direction: Floats, inverse: tuple[Ints, Ints, Floats]) -> Any:
        """Return (c, 2k): direction[chosen[i]] times the row of T^-T."""
        row, column, value = inverse
        place = np.full(self.pair.slots, -1, np.int32)
        place[chosen] = np.arange(len(chosen))
        values = (value[:, None] * direction[row]).ravel()
        shape = (len(chosen), 2 * self.pair.slots)
        return coo_array((values, (np.repeat(place[row], 2), _both(column))), shape=shape).tocsr()

    # --- from derivatives of pieces to sparse matrices --------------------------------------------

    def _columns(self, moved: Ints) -> Ints:
        numbers = np.concatenate([self.pair.slave.nodes, self.pair.master.nodes])
        return 2 * numbers[moved // 2] + moved % 2

    def _turned_normals(self, pieces: PieceDerivatives, values: Floats) -> Any:
        """Return (2k, 2N) of vectors (z, 2) that belong to the derivatives of normals."""
        count = pieces.normal_count
        columns = np.repeat(self._columns(pieces.normal_moved[:count]), 2)
        return self._matrix(_both(pieces.normal_of[:count]), columns, values.ravel(), 2 * self.pair.slots)

    def _gap_derivatives(
        self, pieces: PieceDerivatives, wanted: Floats, at: SurfacePositions, separation: Floats
    ) -> Any:
        pair, out = self.pair, triplets(2 * pieces.count * pieces.multiplier.shape[1])
        nodes = pair.slave.nodes, pair.master.nodes
        count = kernels.gap_derivatives(
            pieces.count, _arrays(pieces), pair.coupling.owner, wanted, tuple(at), separation, nodes, out
        )
        return self._matrix(*_first(out, count), 2 * pair.slots)

    def _by_curves(
        self, smooth: SmoothSurfaces, chosen: Ints, inverse: Any, pieces: PieceDerivatives, wanted: Floats, dnormal: Any
    ) -> Any:
        """Return what smooth surfaces add to gap derivatives: nu . c, c = T^-T C, changes with nu, T and C."""
        pair = self.pair
        shift = smooth.shifts(pair.at)
        nowhere = SurfacePositions(*(np.zeros_like(at) for at in pair.at))
        change = self._gap_derivatives(pieces, wanted, nowhere, shift)
        change = change + self._matrix(*smooth.derivatives(self.memory), 2 * pair.slots)
        return self._spread(chosen, pair.normals, inverse) @ change + self._rows(chosen, shift) @ dnormal

    def _force_derivative(
        self, pieces: PieceDerivatives, wanted: Floats, traction: Floats, weights: Any, y_n: Floats, y_t: Floats | None
    ) -> Any:
        pair, k = self.pair, pieces.multiplier.shape[1]
        direct = triplets(2 * pieces.count * (pieces.slave.shape[1] + pieces.master.shape[1]))
        coupled = triplets(2 * pieces.count * k)
        nodes = pair.slave.nodes, pair.master.nodes
        count, given = kernels.force_derivatives(
            pieces.count, _arrays(pieces), pair.coupling.owner, wanted, traction, nodes, direct, coupled
        )
        of, turn = pieces.normal_of[: pieces.normal_count], pieces.dnormal[: pieces.normal_count]
        dq = y_n[of, None] * turn
        if y_t is not None:
            dq += y_t[of, None] * turned(turn)
        change = self._turned_normals(pieces, dq) - self._matrix(*_first(coupled, given), 2 * pair.slots)
        return self._matrix(*_first(direct, count), self.size) + weights.T @ change

    def _matrix(self, row: Ints, column: Ints, value: Floats, rows: int) -> Any:
        return coo_array((value, (row, column)), shape=(rows, self.size)).tocsr()


class ConsistentLinearisation(PairLinearisation):
    """`PairLinearisation` with normal forces along the derivatives of the gaps; friction stays along weights."""

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add derivatives of gaps times multipliers, and weights times friction forces."""
        force = multipliers.copy()
        own = force[0, self.pair.own]
        chosen = np.flatnonzero(own).astype(np.int32)
        if len(chosen):
            normal += (self.gap_derivatives(chosen).T @ own[chosen]).reshape(-1, 2)
        own[:] = 0.0
        super().add_forces(force, normal, tangential)

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Take changes of directions from rows by weights: their own change needs second derivatives."""
        found = super().linearise(chosen, y)
        return found._replace(normal=found.gap)


def parts_of(y: Floats, pair: ContactPair) -> tuple[Floats, Floats | None]:
    """Return normal forces (k,) of a pair, zero if not given, and tangential forces; None without friction."""
    return (y[0] if len(y) else np.zeros(pair.slots)), y[1] if len(y) > 1 and pair.friction is not None else None


def entries(chosen: Ints, rows: BandedRows, cut: float) -> tuple[Ints, Ints, Floats]:
    """Return entries (row, position, value) above `cut` of the chosen rows."""
    out = triplets(int(np.maximum(rows.end[chosen] - rows.start[chosen], 0).sum()))
    count = banded_rows.entries(chosen, rows, cut, *out)
    return _first(out, count)


def triplets(size: int) -> tuple[Ints, Ints, Floats]:
    """Allocate that many entries (row, column, value)."""
    return np.zeros(size, np.int32), np.zeros(size, np.int32), np.zeros(size)


def _first(triplets: tuple[Ints, Ints, Floats], count: int) -> tuple[Ints, Ints, Floats]:
    row, column, value = triplets
    return row[:count], column[:count], value[:count]


def _both(numbers: Ints) -> Ints:
    """Return 2 n and 2 n + 1 of every number, alternately."""
    both: Ints = np.add.outer(2 * numbers, np.arange(2, dtype=np.int32)).ravel()
    return both


def _arrays(pieces: PieceDerivatives) -> tuple[Ints, Ints, Ints, Ints, Floats, Floats, Floats]:
    return pieces.slave, pieces.multiplier, pieces.master, pieces.moved, pieces.dD, pieces.dM, pieces.dT
