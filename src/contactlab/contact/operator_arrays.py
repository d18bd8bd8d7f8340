"""The arrays of a pair of operators, as kernels are given them."""

from __future__ import annotations

import numpy as np

from contactlab.api import Candidates, Floats, Pieces, Surface
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.surface import SurfacePositions
from contactlab.contact.coupling import Coupling
from contactlab.contact.near_list import Near
from contactlab.kernels.contact import banded_rows
from contactlab.kernels.contact.tables import (
    BandedRows,
    CouplingColumns,
    GapsTable,
    PairTable,
    PlacesTable,
    WeightsTable,
)


class OperatorArrays:
    """Places, pieces, coupling, columns, gaps and rows of one pair of k multipliers.

    All are bound for kernels, which are given `address`; arrays that are made anew with more room are bound anew.

    at, measured  positions of both sides: where pieces are made, and where gaps are measured
    separation    (k, 2) [mm] weighted positions of the slave minus those of the master, `gaps` their parts
    """

    def __init__(
        self,
        slave: Surface,
        master: Surface,
        at: SurfacePositions,
        gaps: Floats,
        widths: tuple[int, int, int],
        coupling: Coupling,
    ) -> None:
        k = len(gaps)
        self.slave, self.master, self.widths = slave, master, widths
        self.at, self.measured = at, SurfacePositions(at.slave.copy(), at.master.copy())
        self.near = Near(_NONE, np.full_like(at.slave, np.inf), np.full_like(at.master, np.inf))
        self.coupling = coupling
        self.pieces = Pieces.allocate(0, widths, k)
        self.separation, self.gaps = np.zeros((k, 2)), gaps
        self.columns = CouplingColumns(BandedRows.allocate(k, 8), BandedRows.allocate(k, 8), np.zeros(1, np.bool_))
        self._weights = WeightsTable(BandedRows.allocate(k, 8), BandedRows.allocate(k, 64))
        self._solved = False
        self._bind()

    def _bind(self) -> None:
        self.bound = BoundArrays(
            PairTable,
            PlacesTable(
                self.slave.nodes, self.master.nodes, self.slave.segments, self.slave.node_segments, *self.at,
                *self.measured, self.near.slave, self.near.master,
            ),
            self.coupling.table,
            self.pieces,
            self.columns,
            GapsTable(self.separation, self.gaps),
            self._weights,
        )  # fmt: skip
        self.address = self.bound.address

    def use(self, near: Near, capacity: int) -> None:
        """Go on with another near list, which may give `capacity` pieces."""
        self.near = near
        if capacity > len(self.pieces.slave):
            self.pieces = Pieces.allocate(capacity + capacity // 4, self.widths, len(self.gaps))
        self._bind()

    def widen(self, slave: int, master: int) -> None:
        """Room for columns of so many weights, where any are lacking."""
        k = len(self.gaps)
        if slave:
            self.columns = self.columns._replace(slave=BandedRows.allocate(k, slave + slave // 2))
        if master:
            self.columns = self.columns._replace(master=BandedRows.allocate(k, master + master // 2))
        self._bind()

    def joined(self) -> None:
        """Coupling and columns are new: rows are made when they are next asked for."""
        self._solved = False

    def weights(self) -> WeightsTable:
        """Weights of both sides' nodes in each condition."""
        if not self._solved:
            slave, master = self._weights
            if self.columns.single[0]:
                banded_rows.own_nodes(self.coupling.bound.address, len(self.slave.nodes), slave)
            else:
                slave = self.coupling.rows(self.columns.slave, slave)
            master = self.coupling.rows(self.columns.master, master)
            if slave is not self._weights.slave or master is not self._weights.master:
                self._weights = WeightsTable(slave, master)
                self._bind()
            self._solved = True
        return self._weights


_NONE = Candidates(np.zeros(0, np.int32), np.zeros(0, np.int32), 0.0)
