"""One contact pair at work: search, pieces, coupling, rows, and back to pressures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contactlab.api import Candidates, ContactAlgorithm, FactoredRows, Floats, FrictionLaw, Ints, Pieces, Rows, Surface
from contactlab.api.arrays import Flags
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.compiled.contact_tables import PiecesTable
from contactlab.api.surface import SurfacePositions
from contactlab.errors import WrongAnswer
from contactlab.kernels.contact import banded_rows, edges, rows
from contactlab.kernels.contact import pair as kernels
from contactlab.kernels.contact.factored_rows import FAR
from contactlab.kernels.contact.tables import (
    BandedRows,
    CouplingColumns,
    GapsTable,
    PairTable,
    PlacesTable,
    WeightsTable,
)
from contactlab.model.contact.coupling import Coupling
from contactlab.model.contact.near_list import REACH, SKIN, Near, longest_segment

_NONE = Candidates(np.zeros(0, np.int32), np.zeros(0, np.int32), 0.0)


class SurfacePair:
    """A slave and a master surface under one `ContactAlgorithm`.

    Multiplier k = slot * m + i of the pair lives at `first_slot + k` of the state's multipliers.
    """

    factored = True  # conditions can be given as `FactoredRows`

    def __init__(
        self,
        name: str,
        algorithm: ContactAlgorithm,
        slave: Surface,
        master: Surface,
        reference: Floats,
        first_slot: int,
        friction: FrictionLaw | None,
        fixed: Flags,
    ) -> None:
        self.name = name
        self.algorithm = algorithm = algorithm if friction is None else algorithm.with_friction()
        self.slave, self.master = slave, master
        self.first_slot, self.friction = first_slot, friction
        m, slots = len(slave.nodes), algorithm.rows_per_node
        self.slots = slots * m
        self.at = SurfacePositions(reference[slave.nodes], reference[master.nodes])
        self.measured = SurfacePositions(self.at.slave.copy(), self.at.master.copy())
        self.size = longest_segment(self.at, slave, master)
        self.coupling = Coupling(slave, slots, algorithm.carriers(slave), fixed)
        self.linear_trace = slave.edges.shape[1] == 2
        self.near: Near | None = None
        self.unchecked = True
        k = self.slots
        self.separation, self.gaps = np.zeros((k, 2)), np.full((k, 2), FAR)
        self.columns = CouplingColumns(BandedRows.allocate(k, 8), BandedRows.allocate(k, 8), np.zeros(1, np.bool_))
        self._weights = WeightsTable(BandedRows.allocate(k, 8), BandedRows.allocate(k, 64))
        self._solved = False
        self.count = 0
        self.skin = SKIN * self.size
        self._room(0)
        self._bind()
        self._prepare_friction()

    @property
    def rows_per_node(self) -> int:
        """Multipliers that a slave node can carry."""
        return self.algorithm.rows_per_node

    @property
    def between(self) -> tuple[Ints, Ints, Ints]:
        """Slave nodes that carry no multiplier, and the carriers that follow and precede each."""
        return self.coupling.between(len(self.slave.nodes))

    @property
    def cover(self) -> Floats:
        """Covered length (k,) [mm] of each multiplier, of the last `update`."""
        return self.coupling.cover

    @property
    def normals(self) -> Floats:
        """Unit vectors (k, 2) of all multipliers, from the master towards the slave, of the last update."""
        return self.pieces.normal

    def _prepare_friction(self) -> None:
        """Tangential arrays, only where friction is declared."""
        self.everywhere = False
        if self.friction is None:
            return
        bound = self.friction.bound()
        self.bound = np.array(bound)
        # a slip bound that holds in the air too needs a row for every multiplier in reach
        self.everywhere = bound.adhesion > 0.0 and not math.isfinite(bound.cap)
        self.before = np.zeros((self.slots, 2))
        self.began = SurfacePositions(self.at.slave.copy(), self.at.master.copy())

    # --- from positions to coupling -------------------------------------------------------------

    def update(self, positions: Floats, memory: Floats) -> None:
        """Search, integrate and factorise at `positions` (N, 2)."""
        self._follow(positions, positions, positions, memory, kernels.AT | kernels.MEASURED)

    def follow(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """`update` at predicted + compliance * force, all (N, 2), and `measure` at `predicted`."""
        self._follow(predicted, compliance, force, memory, kernels.AT | kernels.MEASURED | kernels.PUSHED)
        self.settle()

    def _follow(self, positions: Floats, compliance: Floats, force: Floats, memory: Floats, asked: int) -> None:
        if not kernels.place(self.bound_arrays.address, positions, compliance, force, asked) <= self.skin:
            self.find_near(self.at.slave, self.at.master)
        assert self.near is not None
        count = self.algorithm.pieces(
            self.slave, self.master, self.at, self.near.candidates, REACH * self.size, memory, self.pieces
        )
        if self.unchecked or type(count) is not int or not 0 <= count <= len(self.pieces.slave):
            self._check(count)
        self.count = count
        self._join()

    def _check(self, count: Any) -> None:
        """Raise WrongAnswer for pieces that point outside the arrays, which compiled code would follow."""
        refuse_wrong(self.pieces, count, len(self.slave.nodes), len(self.master.nodes), type(self.algorithm).__name__)
        self.unchecked = False

    def measure(self, positions: Floats) -> None:
        """Separations and gaps of all kept multipliers at `positions`, with the rows of the last `update`."""
        address = self.bound_arrays.address
        kernels.place(address, positions, positions, positions, kernels.MEASURED)
        kernels.measure(address)
        self.settle()

    def settle(self) -> None:
        """What is done to gaps that were just measured: nothing, but for pairs that take overlaps back."""

    def separations(self, at: SurfacePositions, normals: Floats, separation: Floats, gaps: Floats) -> None:
        """Separations (k, 2) and gaps (k, 2) of surfaces at `at`, with the coupling of the last `update`."""
        kernels.measure_at(self.bound_arrays.address, at, normals, separation, gaps)

    def begin(self, positions: Floats, memory: Floats) -> None:
        """Normals of the present pieces at `positions`, where the step starts (friction only)."""
        edges.take(positions, self.slave.nodes, self.began.slave)
        edges.take(positions, self.master.nodes, self.began.master)
        assert self.near is not None
        self.algorithm.normals(
            self.slave, self.master, self.began, self.near.candidates, REACH * self.size, memory, self.pieces,
            self.count, self.before,
        )  # fmt: skip

    def find_near(self, slave: Floats, master: Floats) -> Near:
        """Make the near list anew, for these positions of the surfaces (m, 2)."""
        self.near, self.unchecked = Near.of(self.slave, self.master, slave, master, self.size), True
        capacity = self.algorithm.capacity(self.slave, self.near.candidates)
        if capacity > len(self.pieces.slave):
            self._room(capacity + capacity // 4)
        self._bind()
        return self.near

    def _room(self, capacity: int) -> None:
        widths = self.algorithm.widths(self.slave, self.master)
        if np.shape(widths) != (3,) or min(widths) < 1:
            raise WrongAnswer(
                f"{type(self.algorithm).__name__}: widths gave {widths}, needed: how many slave nodes, multipliers and "
                "master nodes a piece couples"
            )
        self.pieces = Pieces.allocate(capacity, widths, self.slots)

    def _bind(self) -> None:
        """Bind all arrays that kernels of every step work on; anew whenever one of them is another."""
        p = self.pieces
        near = self.near or Near(_NONE, np.full_like(self.at.slave, np.inf), np.full_like(self.at.master, np.inf))
        self.bound_arrays = BoundArrays(
            PairTable,
            PlacesTable(
                self.slave.nodes, self.master.nodes, self.slave.segments, self.slave.node_segments, *self.at,
                *self.measured, near.slave, near.master,
            ),
            self.coupling.table,
            PiecesTable(p.slave, p.multiplier, p.master, p.D, p.M, p.T, p.normal),
            self.columns,
            GapsTable(self.separation, self.gaps),
            self._weights,
        )  # fmt: skip

    def _join(self) -> None:
        """Coupling, columns (widened as needed) and gaps of the pieces."""
        while True:
            kept, lacking, missing = kernels.join(self.bound_arrays.address, self.count, self.linear_trace)
            if kept < 0:
                raise ValueError(f"{self.name}: the slave is a closed curve covered all around; swap slave and master")
            if not lacking and not missing:
                break
            if lacking:
                self.columns = self.columns._replace(slave=BandedRows.allocate(self.slots, lacking + lacking // 2))
            if missing:
                self.columns = self.columns._replace(master=BandedRows.allocate(self.slots, missing + missing // 2))
            self._bind()
        self._solved = False

    def weights(self) -> WeightsTable:
        """Weights of both sides' nodes in each condition of the last update, made when they are first asked for."""
        if not self._solved:
            slave, master = self._weights
            if self.columns.single[0]:
                banded_rows.own_nodes(self.coupling.bound.address, len(self.slave.nodes), slave)
            else:
                slave = self.coupling.rows(self.columns.slave, slave)
            found = WeightsTable(slave, self.coupling.rows(self.columns.master, master))
            if found.slave is not self._weights.slave or found.master is not self._weights.master:
                self._weights = found
                self._bind()
            self._solved = True
        return self._weights

    @property
    def rows_address(self) -> int:
        """Where kernels find the arrays of this pair, `weights` up to date."""
        self.weights()
        return self.bound_arrays.address

    # --- from coupling to rows ------------------------------------------------------------------

    def append_factored(self, out: FactoredRows) -> bool:
        """Append all conditions to `out`; False where it is too small."""
        count = kernels.append_factored(self.bound_arrays.address, self.first_slot, out.count, out.packed.address)
        if count >= 0:
            out.count = count
        return bool(count >= 0)

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`.

        Returns the next free entry, or -1 where `out` is too small. `current` (N, 2) are the
        positions at the start of the step, used with friction.
        """
        if self.everywhere:
            margin = FAR
        first = out.count
        address, packed = self.rows_address, out.packed.address
        count, end = rows.write_rows(address, min(margin, FAR), multipliers, self.first_slot, first, entries, packed)
        if count < 0:
            return -1
        if self.friction is not None:
            out.bound[:, first:count] = self.bound[:, None]
            measured = self.gaps, self.pieces.normal, self.before
            rows.write_slips(first, count, self.first_slot, measured, current, packed)
        elif len(out.slip):
            out.bound[:, first:count] = 0.0
            out.slip[first:count] = 0.0
        out.count = count
        return int(end)

    # --- from multipliers to pressures ----------------------------------------------------------

    def tractions(self, forces: Floats) -> Floats:
        """Lambda (k,) [MPa] from nodal forces y (k,) [N]: T^-1 y, the owner's value where merged, 0 off cover."""
        return self.coupling.solve(forces)


def refuse_wrong(pieces: Pieces, count: Any, slave_nodes: int, master_nodes: int, part: str) -> None:
    """Raise WrongAnswer where the first `count` pieces of a part are not as the contract says."""
    room = len(pieces.slave)
    if not isinstance(count, int | np.integer) or not 0 <= count <= room:
        raise WrongAnswer(
            f"{part}: pieces gave {count}, needed: how many of the {room} pieces of its capacity are filled"
        )
    sides = {"slave": slave_nodes, "multiplier": len(pieces.normal), "master": master_nodes}
    for name, size in sides.items():
        used = getattr(pieces, name)[:count]
        if used.size and not 0 <= used.min() <= used.max() < size:
            wrong = used.min() if used.min() < 0 else used.max()
            raise WrongAnswer(f"{part}: pieces filled {name} with {wrong}, needed: positions 0 to {size - 1}")
