"""Derivatives of the gaps, slips and nodal forces of one contact pair by the positions of its nodes.

With tractions a = T^-1 q, nodal forces are D a and -M a; separations are r = T^-T (D^T x - M^T y), gaps
g = nu . r. Their derivatives need only those D, M, T and nu, which are local to an integration segment:

    d r = P dx + T^-T (dD^T x - dM^T y - dT^T r)            P = T^-T [D^T | -M^T]
    d f = [dD; -dM] a + P^T (dq - dT a)                      q = y_n nu + y_t tau
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from contactlab.api import ContactDerivatives, Floats, Ints
from contactlab.api.derivatives import PieceDerivatives
from contactlab.api.surface import SurfacePositions
from contactlab.contact.cornered_pair import CorneredPair
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, turned
from contactlab.implicit.sparse import compressed, picked, product, summed, total, transposed
from contactlab.kernels.contact import weights as kernels
from contactlab.kernels.contact.pair import BandedRows

Entries = tuple[Ints, Ints, Floats]  # rows, columns, values; entries at the same place are added
Parts = tuple[dict[tuple[int, int], Entries], list[Entries]]
"""Each kind of rows, gaps and slips, is a sum of parts (kind, change) times these changes."""

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

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return rows (c, 2N) of the chosen multipliers at the end of a whole step, normal and tangential."""
        raise NotImplementedError(f"{type(self).__name__} has no rows of whole steps")


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
    elif pair.smooth:
        from contactlab.contact.smooth_pair import SmoothLinearisation

        found = SmoothLinearisation(pair, nodes)
    else:
        found = (ConsistentLinearisation if consistent and not whole_steps else PairLinearisation)(pair, nodes)
        if isinstance(pair, CorneredPair):
            from contactlab.contact.taken_linearisation import TakenLinearisation

            found = TakenLinearisation(found, pair.corners)  # passes through unless a corner is touched
    if whole_steps:
        from contactlab.contact.step_rows import StepRows

        return StepRows(found)
    return found


class PairLinearisation(Linearisation):
    """Linearisation of a pair whose algorithm gives operators, with forces P^T q along weights and normals.

    Only their directions are called frozen: they are nu . P, not all of d g. Derivatives of gaps, slips and forces
    contain the changes of weights and normals.
    """

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
        directions = [pair.normals] if y_t is None else [pair.normals, turned(pair.normals)]
        traction = self._tractions(y_n, y_t)
        # the chosen rows of T^-T
        self.inverse = kernels.inverse_rows(pair.coupling, self.inverse)
        inverse = entries(chosen, self.inverse, CUT)
        size = np.hypot(*traction.T)
        wanted = size > CUT * max(float(size.max(initial=0.0)), 1e-300)
        wanted[inverse[1]] = True
        weights = self._matrix(self._weights(np.flatnonzero(wanted).astype(np.int32)))
        along = product(self._times(chosen, directions), weights)
        change = total(along, self._changes(chosen, directions, inverse, pieces, wanted))
        force = self._force_derivative(pieces, wanted, traction, weights, y_n, y_t) if len(y) else None
        if y_t is None:
            return ContactDerivatives(along, None, change, None, force)
        normal, tangent = np.split(np.arange(2 * len(chosen)), 2)
        of_kind = (picked(rows, kind) for rows in (along, change) for kind in (normal, tangent))
        return ContactDerivatives._make((*of_kind, force))

    def _changes(
        self, chosen: Ints, directions: list[Floats], inverse: Entries, pieces: PieceDerivatives, wanted: Floats
    ) -> Any:
        """Return derivatives of gaps by weights and normals (c, 2N); with friction the derivatives of slips follow.

            d g - nu . P dx = nu . T^-T w + dnu . r,          w = dD^T x - dM^T y - dT^T r
            d s - tau . P dx = tau . T^-T w + dtau . r - tau_0 . T^-T w_0

        w_0 belongs to the positions and separations at the start of the step, tau_0 to its normals.
        """
        parts, changes = self._parts(chosen, directions, inverse, pieces, wanted)
        place = np.full(self.pair.slots, -1, np.int32)
        place[chosen] = np.arange(len(chosen))
        rows, columns = len(chosen), 2 * self.pair.slots
        left = [(kind * rows + place[at], of * columns + j, x) for (kind, of), (at, j, x) in parts.items()]
        right = [(of * columns + row, j, x) for of, (row, j, x) in enumerate(changes)]
        between = columns * len(changes)
        return product(_sparse(left, (rows * len(directions), between)), _sparse(right, (between, self.size)))

    def _parts(
        self, chosen: Ints, directions: list[Floats], inverse: Entries, pieces: PieceDerivatives, wanted: Floats
    ) -> Parts:
        pair, separation, own = self.pair, self.pair.separation, (chosen, chosen, np.ones(len(chosen)))
        changes = [self._weight_changes(pieces, wanted, pair.at, separation), self._normal_changes(pieces)]
        parts = {(0, 0): spread(inverse, pair.normals), (0, 1): spread(own, separation)}
        if len(directions) > 1:
            assert pair.sliding is not None
            changes.append(self._weight_changes(pieces, wanted, pair.sliding.began, self.start_separation))
            # tau . r = nu . (r turned by +90 degrees)
            parts[1, 0], parts[1, 1] = spread(inverse, directions[1]), spread(own, -turned(separation))
            parts[1, 2] = spread(inverse, -turned(pair.sliding.before))
        return parts, changes

    def tangents(self, chosen: Ints) -> Any:
        """Return weights times tangents."""
        return product(self._times(chosen, [turned(self.pair.normals)]), self._matrix(self._weights(chosen)))

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

    def _weights(self, chosen: Ints) -> Entries:
        """Return entries of P, in rows 2 k + component, for the chosen multipliers."""
        pair, parts = self.pair, []
        sides, numbered = pair.weights(), (pair.slave.nodes, pair.master.nodes)
        for side, numbers, sign in zip(sides, numbered, (1.0, -1.0), strict=True):
            row, column, value = entries(chosen, side, CUT)
            parts.append((row, numbers[column], sign * value))
        row, column, value = (np.concatenate(part) for part in zip(*parts, strict=True))
        return _both(row), _both(column), np.repeat(value, 2)

    def _times(self, chosen: Ints, vectors: list[Floats]) -> Any:
        """Return, for each vectors (k, 2), rows (c, 2k) with vectors[chosen[i]] at their own place in row i."""
        values = np.concatenate([some[chosen] for some in vectors]).ravel()
        shape = (len(vectors) * len(chosen), 2 * self.pair.slots)
        start = np.arange(0, len(values) + 1, 2, dtype=np.int32)
        return compressed(values, np.tile(_both(chosen), len(vectors)), start, shape)

    # --- from derivatives of pieces to sparse matrices --------------------------------------------

    def _columns(self, moved: Ints) -> Ints:
        numbers = np.concatenate([self.pair.slave.nodes, self.pair.master.nodes])
        return 2 * numbers[moved // 2] + moved % 2

    def _normal_changes(self, pieces: PieceDerivatives, factors: Floats | None = None) -> Entries:
        """Return entries of the derivatives of normals, rows 2 k + component, or of other vectors (z, 2) in place."""
        count = pieces.normal_count
        values = pieces.dnormal[:count] if factors is None else factors
        columns = np.repeat(self._columns(pieces.normal_moved[:count]), 2)
        return _both(pieces.normal_of[:count]), columns, values.ravel()

    def _weight_changes(
        self, pieces: PieceDerivatives, wanted: Floats, at: SurfacePositions, separation: Floats
    ) -> Entries:
        """Return entries of the derivatives of weighted separations by changes of weights, rows 2 k + component."""
        pair, out = self.pair, triplets(2 * pieces.count * pieces.multiplier.shape[1])
        count = kernels.gap_derivatives(
            pieces.count, _arrays(pieces), pair.coupling.owner, wanted, tuple(at), separation, self._nodes, out
        )
        return _first(out, count)

    def _force_derivative(
        self, pieces: PieceDerivatives, wanted: Floats, traction: Floats, weights: Any, y_n: Floats, y_t: Floats | None
    ) -> Any:
        pair, k = self.pair, pieces.multiplier.shape[1]
        direct = triplets(2 * pieces.count * (pieces.slave.shape[1] + pieces.master.shape[1]))
        coupled = triplets(2 * pieces.count * k)
        count, given = kernels.force_derivatives(
            pieces.count, _arrays(pieces), pair.coupling.owner, wanted, traction, self._nodes, direct, coupled
        )
        row, column, value = _first(coupled, given)
        of, turn = pieces.normal_of[: pieces.normal_count], pieces.dnormal[: pieces.normal_count]
        dq = y_n[of, None] * turn
        if y_t is not None:
            dq += y_t[of, None] * turned(turn)
        change = self._matrix(self._normal_changes(pieces, dq), (row, column, -value))
        return total(summed(*_first(direct, count), (self.size, self.size)), product(transposed(weights), change))

    @property
    def _nodes(self) -> tuple[Ints, Ints]:
        return self.pair.slave.nodes, self.pair.master.nodes

    def _matrix(self, *parts: Entries) -> Any:
        return _sparse(parts, (2 * self.pair.slots, self.size))


class ConsistentLinearisation(PairLinearisation):
    """`PairLinearisation` with normal forces along the derivatives of the gaps; friction stays along weights."""

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add derivatives of gaps times multipliers, and weights times friction forces."""
        super().add_forces(multipliers, normal, tangential)
        pair, y = self.pair, multipliers[0, self.pair.own]
        if not y.any():
            return
        pieces, traction = pair.derivatives(self.memory), self._tractions(y, None)
        separation, force = pair.separation, normal.reshape(-1)
        kernels.add_weight_changes(
            pieces.count, _arrays(pieces), pair.coupling.owner, traction, tuple(pair.at), separation, self._nodes, force
        )
        row, column, value = self._normal_changes(pieces)
        np.add.at(force, column, (y[:, None] * separation).ravel()[row] * value)

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Take changes of directions from rows by weights: their own change needs second derivatives."""
        found = super().linearise(chosen, y)
        return found._replace(normal=found.gap)


def parts_of(y: Floats, pair: ContactPair) -> tuple[Floats, Floats | None]:
    """Return normal forces (k,) of a pair, zero if not given, and tangential forces; None without friction."""
    return (y[0] if len(y) else np.zeros(pair.slots)), y[1] if len(y) > 1 and pair.friction is not None else None


def entries(chosen: Ints, rows: BandedRows, cut: float) -> Entries:
    """Return entries (row, position, value) above `cut` of the chosen rows."""
    out = triplets(int(np.maximum(rows.end[chosen] - rows.start[chosen], 0).sum()))
    count = kernels.entries(chosen, rows, cut, *out)
    return _first(out, count)


def spread(rows: Entries, vectors: Floats) -> Entries:
    """Return entries times the components of vectors (k, 2) of their rows, in columns 2 column + component."""
    row, column, value = rows
    return np.repeat(row, 2), _both(column), (value[:, None] * vectors[row]).ravel()


def _sparse(parts: Sequence[Entries], shape: tuple[int, int]) -> Any:
    row, column, value = (np.concatenate(part) for part in zip(*parts, strict=True))
    return summed(row, column, value, shape)


def triplets(size: int) -> Entries:
    """Allocate that many entries (row, column, value)."""
    return np.zeros(size, np.int32), np.zeros(size, np.int32), np.zeros(size)


def _first(triplets: Entries, count: int) -> Entries:
    row, column, value = triplets
    return row[:count], column[:count], value[:count]


def _both(numbers: Ints) -> Ints:
    """Return 2 n and 2 n + 1 of every number, alternately."""
    both: Ints = np.add.outer(2 * numbers, np.arange(2, dtype=np.int32)).ravel()
    return both


def _arrays(pieces: PieceDerivatives) -> tuple[Ints, Ints, Ints, Ints, Floats, Floats, Floats]:
    return pieces.slave, pieces.multiplier, pieces.master, pieces.moved, pieces.dD, pieces.dM, pieces.dT
