"""Mortar constraints taken at corners of the master, for implicit integrators (`contact.corners`)."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ContactDerivatives, Floats, Ints
from contactlab.contact.corners import Corners, Moved
from contactlab.contact.linearisation import ConsistentLinearisation, Linearisation, PairLinearisation
from contactlab.implicit.sparse import product, summed, total


class TakenLinearisation(Linearisation):
    """Another linearisation of a pair, with constraints of nodes beyond corners taken at the corners."""

    def __init__(self, linear: PairLinearisation, corners: Corners) -> None:
        self.linear, self.corners = linear, corners
        self.pair, self.size, self.memory = linear.pair, linear.size, linear.memory
        self.present, self.gap, self.slip = linear.present, linear.gap, linear.slip

    def evaluate(self, position: Floats, start: Floats) -> None:
        """Evaluate the pair, whose gaps are taken at the corners already, and take slips there."""
        self.corners.start = start[self.pair.slave.nodes]
        self.linear.evaluate(position, start)
        if len(self.slip):
            self.corners.take(self.slip[:, None])

    def flexibilities(self, nodal: Floats) -> Floats:
        """Return flexibilities at the nodes."""
        return self.linear.flexibilities(nodal)

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add forces at the nodes, and changes of gaps as corners slide along their segments."""
        own = self.pair.own
        at_nodes = multipliers.copy()
        at_nodes[:, own] = self.corners.at_nodes(multipliers[:, own])
        self.linear.add_forces(at_nodes, normal, tangential)
        if isinstance(self.linear, ConsistentLinearisation):
            for moved in self.corners.moved:
                change = self.corners.change(moved, self.gap)
                np.add.at(normal, moved.nodes, multipliers[0, own][moved.slot] * change * moved.rates)

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Combine shares of both constraints, with the derivatives of the shares."""
        if not self.corners.moved:
            return self.linear.linearise(chosen, y)
        loaded = [moved for moved in self.corners.moved if y[:, moved.slot].any()]
        more, pick = self._with_partners(chosen, [k for moved in loaded for k in (moved.slot, moved.partner)])
        found = self.linear.linearise(more, self.corners.at_nodes(y))
        normal, force = product(pick, found.normal), found.force
        gap = total(product(pick, found.gap), self._by_shares(chosen, self.gap))
        if isinstance(self.linear, ConsistentLinearisation):
            normal = gap
        tangent = slip = None
        if found.tangent is not None:
            tangent = product(pick, found.tangent)
            slip = total(product(pick, found.slip), self._by_shares(chosen, self.slip))
        if loaded:
            force = total(force, self._force_by_shares(y, loaded, more, found))
        return ContactDerivatives(normal, tangent, gap, slip, force)

    def tangents(self, chosen: Ints) -> Any:
        """Return shares of both tangents."""
        if not self.corners.moved:
            return self.linear.tangents(chosen)
        more, pick = self._with_partners(chosen, [])
        return product(pick, self.linear.tangents(more))

    def _with_partners(self, chosen: Ints, others: list[int]) -> tuple[Ints, Any]:
        """Return multipliers that the chosen multipliers need, with `others`, and the matrix (c, needed) of shares."""
        taken = {moved.slot: moved for moved in self.corners.moved}
        partners = [taken[k].partner for k in chosen if k in taken]
        needed = np.unique([*chosen, *partners, *others]).astype(np.int32)
        place = np.searchsorted(needed, chosen)
        row, column, value = list(range(len(chosen))), list(place), [1.0] * len(chosen)
        for c, k in enumerate(chosen):
            if k in taken:
                value[c] = taken[k].share
                row.append(c)
                column.append(np.searchsorted(needed, taken[k].partner))
                value.append(1.0 - taken[k].share)
        return needed, summed(np.array(row), np.array(column), np.array(value), (len(chosen), len(needed)))

    def _by_shares(self, chosen: Ints, values: Floats) -> Any:
        """Return derivatives (c, 2N) of values (k,) by the shares of the chosen multipliers."""
        place = {int(k): c for c, k in enumerate(chosen)}
        taken = [moved for moved in self.corners.moved if moved.slot in place]
        rows = [np.full(6, place[moved.slot]) for moved in taken]
        changes = [self.corners.change(moved, values) * moved.rates.ravel() for moved in taken]
        return self._matrix(rows, [_both(moved.nodes) for moved in taken], changes, len(chosen))

    def _force_by_shares(self, y: Floats, loaded: list[Moved], more: Ints, found: ContactDerivatives) -> Any:
        """Return derivatives (2N, 2N) of nodal forces by the shares that pass them from node to node.

        `found` are derivatives of the multipliers `more`.
        """
        rows, columns, values = [], [], []
        for moved in loaded:
            sign = (more == moved.slot) * 1.0 - (more == moved.partner)
            along = y[0, moved.slot] * (sign @ found.normal)
            if found.tangent is not None:
                along = along + y[1, moved.slot] * (sign @ found.tangent)
            force = np.flatnonzero(along).astype(np.int32)
            rows.append(np.repeat(force, 6))
            columns.append(np.tile(_both(moved.nodes), len(force)))
            values.append(np.outer(along[force], moved.rates.ravel()).ravel())
        return self._matrix(rows, columns, values, self.size)

    def _matrix(self, row: list[Ints], column: list[Ints], value: list[Floats], rows: int) -> Any:
        none = np.zeros(0, np.int32)
        parts = np.concatenate([none, *row]), np.concatenate([none, *column]), np.concatenate([np.zeros(0), *value])
        return summed(*parts, (rows, self.size))


def _both(nodes: Ints) -> Ints:
    """Return both coordinates of nodes."""
    return np.add.outer(2 * nodes, np.arange(2, dtype=np.int32)).ravel()
