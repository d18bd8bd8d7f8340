"""Derivatives of the gaps, slips and nodal forces of finished gap constraints by node positions.

Gaps and slips are sums of weights times positions; nodal forces are weights times multipliers.
So all derivatives follow from the derivatives of the weights w_z alone (docs/parts/derivatives.md):

    d g = sum_z (w_z . dx_z + dw_z . x_z),    d f = sum_z y dw_z
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ConditionDerivatives, ContactDerivatives, Floats, GapConditions, Ints
from contactlab.contact.condition_differences import ConditionDifferences
from contactlab.contact.corner_pair import CornerPair
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.linearisation import Linearisation, parts_of
from contactlab.contact.pair import turned
from contactlab.errors import WrongAnswer
from contactlab.implicit.sparse import compressed, product, summed, total


class GapLinearisation(Linearisation):
    """Linearisation of a pair of finished constraints."""

    pair: GapPair

    def __init__(self, pair: GapPair, nodes: int) -> None:
        super().__init__(pair, nodes)
        self.differences = ConditionDifferences(pair)
        self.position, self.start = np.zeros((nodes, 2)), np.zeros((nodes, 2))

    def evaluate(self, position: Floats, start: Floats) -> None:
        """Update the pair at `position`."""
        pair = self.pair
        pair.update(position, self.memory)
        self.position[:], self.start[:] = position, start
        if pair.sliding is None:
            return
        pair.compute_start_normals(start, self.memory)
        self.slip[:] = 0.0
        found = self._found
        if len(found.owner):
            now, before = self._directions()
            # one difference for each entry: a surface that has not moved has not slipped, to the last bit
            share = _dot(now, found.tangent_weight)
            moved = share * (_dot(now, self.position[found.node]) - _dot(before, self.start[found.node]))
            self.slip[found.owner] = np.add.reduceat(moved, found.start[:-1])

    def flexibilities(self, nodal: Floats) -> Floats:
        """Sum squared weights."""
        found, out = self._found, np.zeros(self.pair.slots)
        if len(found.owner):
            out[found.owner] = np.add.reduceat(_dot(found.normal_weight**2, nodal[found.node]), found.start[:-1])
        return out

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add weights times multipliers."""
        found, first = self._found, self.pair.first_slot
        slot = first + found.owner[self._row]
        np.add.at(normal, found.node, multipliers[0, slot, None] * found.normal_weight)
        if self.pair.friction is not None:
            np.add.at(tangential, found.node, multipliers[1, slot, None] * found.tangent_weight)

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Build derivatives from the derivatives of the weights."""
        y_n, y_t = parts_of(y, self.pair)
        found, changes, row = self._found, self._changes(), self._row
        entry, value = changes.entry, changes.value
        # weights sum to zero, and so do their changes: distances within a constraint err less than positions
        first = found.start[:-1][row]
        apart = (self.position[found.node] - self.position[found.node[first]])[entry]
        of, pick = row[entry], self._picked(chosen)
        normal = self._weights(found.normal_weight)
        gap = total(normal, self._matrix(of, changes.moved, _dot(value, apart), len(found.owner)))
        change = y_n[found.owner[of], None] * value
        if y_t is None:
            force = self._forces(changes, change)
            return ContactDerivatives(product(pick, normal), None, product(pick, gap), None, force)
        change = change + y_t[found.owner[of], None] * turned(value)
        now, before = self._directions()
        began = (self.start[found.node] - self.start[found.node[first]])[entry]
        share = _dot(now[entry], turned(value))
        slid = share * (_dot(now[entry], apart) - _dot(before[entry], began))
        # contribution of a turning tangent, if it differs from the change of the weights
        across = _dot(turned(value), apart) - share * _dot(now[entry], apart)
        tangent = self._weights(found.tangent_weight)
        slip = total(tangent, self._matrix(of, changes.moved, slid + across, len(found.owner)))
        rows = (product(pick, one) for one in (normal, tangent, gap, slip))
        return ContactDerivatives._make((*rows, self._forces(changes, change)))

    def tangents(self, chosen: Ints) -> Any:
        """Return weights of friction."""
        return product(self._picked(chosen), self._weights(self._found.tangent_weight))

    # --- data of the last evaluation ------------------------------------

    @property
    def _found(self) -> GapConditions:
        assert self.pair.found is not None
        return self.pair.found

    @property
    def _row(self) -> Ints:
        """The constraint (z,) of each entry."""
        start = self._found.start
        return np.repeat(np.arange(len(start) - 1), np.diff(start))

    def _directions(self) -> tuple[Floats, Floats]:
        """Return tangents (z, 2) of each entry's constraint now, and at the start of the step."""
        assert self.pair.sliding is not None
        owner = self._found.owner[self._row]
        return turned(self.pair.normals)[owner], turned(self.pair.sliding.before)[owner]

    def _changes(self) -> ConditionDerivatives:
        pair, found = self.pair, self._found
        view = pair.seen(self.memory)._replace(memory=self.memory.copy())
        given = pair.algorithm.derivatives(view, found)
        if given is None:
            return self.differences.of(self.memory)
        _refuse_wrong(given, len(found.node), self.size, type(pair.algorithm).__name__)
        return given

    # --- sparse matrices --------------------------------------------------------------------------

    def _picked(self, chosen: Ints) -> Any:
        """Return (c, constraints), which picks the chosen slots; a slot without a constraint has an empty row."""
        place = np.full(self.pair.slots, -1)
        place[self._found.owner] = np.arange(len(self._found.owner))
        row = np.flatnonzero(place[chosen] >= 0)
        shape = len(chosen), len(self._found.owner)
        return summed(row, place[chosen][row], np.ones(len(row)), shape)

    def _weights(self, weight: Floats) -> Any:
        found = self._found
        columns = np.add.outer(2 * found.node, np.arange(2)).ravel()
        shape = len(found.owner), self.size
        return compressed(weight.ravel(), columns, 2 * found.start, shape)

    def _forces(self, changes: ConditionDerivatives, change: Floats) -> Any:
        row = np.add.outer(2 * self._found.node[changes.entry], np.arange(2)).ravel()
        return self._matrix(row, np.repeat(changes.moved, 2), change.ravel(), self.size)

    def _matrix(self, row: Ints, column: Ints, value: Floats, rows: int) -> Any:
        return summed(row, column, value, (rows, self.size))


def _dot(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.einsum("zi,zi->z", one, other))


def _refuse_wrong(given: Any, entries: int, coordinates: int, part: str) -> None:
    """Raise WrongAnswer with the entry of a plugin component's derivatives that breaks the contract."""
    if not isinstance(given, ConditionDerivatives):
        raise WrongAnswer(
            f"{part}: derivatives gave {type(given).__name__}, needed: ConditionDerivatives, or None for differences"
        )
    t = len(given.entry)
    if np.shape(given.moved) != (t,) or np.shape(given.value) != (t, 2):
        raise WrongAnswer(
            f"{part}: derivatives of {t} entries have moved {np.shape(given.moved)} and value {np.shape(given.value)}, "
            f"needed ({t},) and ({t}, 2)"
        )
    limits = {"entry": (given.entry, entries), "moved": (given.moved, coordinates)}
    for name, (numbers, limit) in limits.items():
        if t and not 0 <= np.min(numbers) <= np.max(numbers) < limit:
            raise WrongAnswer(f"{part}: derivatives filled {name} outside 0 to {limit - 1}")
    if not np.isfinite(given.value).all():
        raise WrongAnswer(f"{part}: derivatives gave a value that is not finite, from finite numbers")


class CornerLinearisation(GapLinearisation):
    """Derivatives at corners of the master in closed form: segments turn, and corners slide on them."""

    pair: CornerPair

    def _changes(self) -> ConditionDerivatives:
        touched, found = self.pair.touched, self._found
        value = np.zeros((len(touched), 3, 6, 2))
        for c, touch in enumerate(touched):
            turn = np.outer(np.outer((0.0, 1.0, -1.0), touch.outward).ravel() / touch.length, touch.along)
            slide = np.outer(touch.rates.ravel(), touch.outward)
            value[c] = turn, (touch.xi - 1.0) * turn + slide, -touch.xi * turn - slide
        entry = np.repeat(np.arange(len(found.node), dtype=np.int32), 6)
        moved = np.add.outer(2 * found.node.reshape(-1, 3), np.arange(2, dtype=np.int32)).reshape(-1, 6)
        return ConditionDerivatives(entry, np.repeat(moved, 3, axis=0).ravel(), value.reshape(-1, 2))


def linearised_gaps(pair: Any, nodes: int) -> GapLinearisation:
    """Return the linearisation of a pair of finished constraints, in a model of `nodes` nodes."""
    return (CornerLinearisation if isinstance(pair, CornerPair) else GapLinearisation)(pair, nodes)
