"""A contact pair whose algorithm gives operators: search, integration segments, coupling, constraints, pressures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import (
    ContactAlgorithm,
    ContactView,
    FactoredRows,
    Floats,
    FrictionLaw,
    Ints,
    Pieces,
    PointContact,
    Rows,
    State,
    Surface,
)
from contactlab.api.arrays import Flags
from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.derivatives import PieceDerivatives
from contactlab.api.surface import SurfacePositions
from contactlab.contact.corner_report import corner_pieces, with_shares
from contactlab.contact.examination import copies, refuse_written
from contactlab.contact.pair import ContactPair, ContactSnapshot
from contactlab.errors import WrongAnswer
from contactlab.kernels.contact import pair as kernels
from contactlab.kernels.contact import weights as weight_kernels
from contactlab.kernels.contact.coupling import Coupling
from contactlab.kernels.contact.pair import FAR, BandedRows, BothSides, PairTable
from contactlab.kernels.contact.search import SKIN, Near

OWN_ENTRIES = 16  # room for derivatives that an algorithm gives, for each node and multiplier of a piece
OWN_NORMALS = 32  # room for derivatives of normals that depend on a piece, for each piece


class OperatorPair(ContactPair):
    """A slave and a master surface under one `ContactAlgorithm`.

    Kernels find its arrays, a `PairTable`, at `address`. Arrays without room are replaced, and all bound again.

    count       number of integration segments of the last `update`
    pieces      their arrays, `count` of them in use
    coupling    the factorised T of the last `update`; the columns are of D and M
    separation  (k, 2) [mm] weighted slave positions minus weighted master positions, as last measured
    measured    positions of the nodes of both sides at which gaps are measured
    before      their positions in the near list
    lumped      True if T of the last `update` was made diagonal: as the algorithm asks, or since a closed chain
                overlaps all around
    """

    factored = True

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
        algorithm = algorithm if friction is None else algorithm.with_friction()
        super().__init__(name, algorithm, slave, master, reference, first_slot, friction)
        self.algorithm, self.count, k = algorithm, 0, self.slots
        self.coupling = Coupling(
            slave, algorithm.rows_per_node, algorithm.carriers(slave), fixed, algorithm.merged_below
        )
        widths = algorithm.widths(slave, master)
        if np.shape(widths) != (3,) or min(widths) < 1:
            raise WrongAnswer(
                f"{type(algorithm).__name__}: widths gave {widths}, needed: how many slave nodes, multipliers and "
                "master nodes a piece couples"
            )
        self.cover, self.full, self.widths = self.coupling.cover, self.coupling.full, widths
        self.measured, self.separation = SurfacePositions(*(x.copy() for x in self.at)), np.zeros((k, 2))
        self.before = SurfacePositions(*(np.full_like(x, np.inf) for x in self.at))
        self.pieces = Pieces.allocate(0, self.widths, k)
        self.columns = BothSides(BandedRows.allocate(k, 8), BandedRows.allocate(k, 8))
        self._weights = BothSides(BandedRows.allocate(k, 8), BandedRows.allocate(k, 64))
        self._solved, self._unchecked, self.lumped = False, True, False
        self._derivatives: PieceDerivatives | None = None
        self._differences: Callable[[Floats], PieceDerivatives] | None = None
        self._bind()
        self._prepare(reference)

    def _prepare(self, reference: Floats) -> None:
        """Make what kinds of pairs have of their own, from positions before the run."""

    def _bind(self) -> None:
        slave, at = self.slave, (*self.at, *self.measured, *self.before)
        places = (slave.nodes, self.master.nodes, slave.segments, slave.node_segments, *at)
        self.normals = self.pieces.normal
        self.bound = BoundArrays(
            PairTable, places, self.coupling.table, self.pieces, self.columns, self.separation, self.gaps, self._weights
        )
        self.address = self.bound.address

    @property
    def between(self) -> tuple[Ints, Ints, Ints]:
        """Return slave nodes without multiplier, and the next and previous node with a multiplier for each."""
        return self.coupling.between(len(self.slave.nodes))

    def calls_per_step(self) -> dict[str, int]:
        """Count pieces once, and normals at the start of the step once with friction."""
        return {"contact pieces": 1, "contact normals": int(self.friction is not None)}

    # --- from positions to coupling -------------------------------------------------------------

    def update(self, positions: Floats, memory: Floats) -> None:
        """Search, integrate and factorise at `positions` (N, 2)."""
        self._make(positions, positions, positions, memory, False)

    def update_pushed(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """Call `update` at predicted + compliance * force, all (N, 2), and measure gaps at `predicted`."""
        self._make(predicted, compliance, force, memory, True)

    def _make(self, positions: Floats, compliance: Floats, force: Floats, memory: Floats, pushed: bool) -> None:
        if not kernels.place(self.address, positions, compliance, force, pushed) <= SKIN * self.size:
            self.find_near(self.at.slave, self.at.master)
        pieces = self.pieces
        view = self.seen(memory)
        before = copies(view) if self._unchecked else {}
        # of a mortar the kernel `contactlab.formulas.segment_kernels.pieces`; the methods between only bind arrays
        count = self.algorithm.pieces(view, pieces)
        if before:
            refuse_written(view, before, self.algorithm, "pieces")
        if before or type(count) is not int or not 0 <= count <= len(pieces.slave):
            # compiled code would follow pieces that point outside the arrays
            nodes = len(self.slave.nodes), len(self.master.nodes)
            refuse_wrong(pieces, count, *nodes, type(self.algorithm).__name__)
            self._unchecked = False
        self.count = count
        self._join(view)
        self._take_start_gaps(self.gaps)

    def _join(self, view: ContactView) -> None:
        """Compute coupling, columns (widened as needed) and gaps of the integration segments."""
        straight, k, self.lumped = self.slave.edges.shape[1] == 2, self.slots, self.algorithm.lumped
        if self.lumped:
            _lump(self.pieces.T[: self.count])
        while True:
            kept, slave, master = kernels.join(self.address, self.count, straight)
            if kept < 0:
                self.lumped = True
                _lump(self.pieces.T[: self.count])
                continue
            if not slave and not master:
                break
            own, other = self.columns
            self.columns = BothSides(
                BandedRows.allocate(k, slave + slave // 2) if slave else own,
                BandedRows.allocate(k, master + master // 2) if master else other,
            )
            self._bind()
        self._solved = False

    def gaps_at(self, positions: Floats) -> Floats:
        """Return gaps (k, 2) at `positions` with the rows of the last `update`, in a new array."""
        at = SurfacePositions(positions[self.slave.nodes], positions[self.master.nodes])
        separation, gaps = np.zeros((self.slots, 2)), np.zeros((self.slots, 2))
        self.separations(at, self.normals, separation, gaps)
        return gaps

    def separations(self, at: SurfacePositions, normals: Floats, separation: Floats, gaps: Floats) -> None:
        """Compute separations (k, 2) and gaps (k, 2) of surfaces at `at`, with the coupling of the last `update`."""
        kernels.compute_gaps_at(self.address, at, normals, separation, gaps)

    def compute_start_normals(self, positions: Floats, memory: Floats) -> None:
        """Compute normals of the present integration segments at `positions`, the start of the step (friction only)."""
        assert self.sliding is not None
        self.algorithm.normals(self._start(positions, memory), self.pieces, self.count, self.sliding.before)

    def derivatives(self, memory: Floats) -> PieceDerivatives:
        """Return derivatives of the integration segments at their present positions; the same object every call.

        They come from the algorithm, or from differences.
        """
        room = OWN_ENTRIES * self.count * sum(self.widths), 20 * self.slots + OWN_NORMALS * self.count
        found = self.room_for_derivatives(*room)
        # of a mortar the kernel `contactlab.formulas.segment_derivatives.piece_derivatives`
        if not self.algorithm.derivatives(self.seen(memory), self.pieces, self.count, found):
            if self._differences is None:
                from contactlab.contact.differences import Differences

                self._differences = Differences(self).of
            found = self._differences(memory)
        if self.lumped:
            _lump(found.dT[: found.count])
        return found

    def room_for_derivatives(self, entries: int, normals: int) -> PieceDerivatives:
        """Return arrays with room for so many derivatives of integration segments and of normals."""
        room = self._derivatives
        if room is None or entries > len(room.moved) or normals > len(room.normal_moved):
            room = PieceDerivatives.allocate(entries + entries // 4, self.widths, normals)
            self._derivatives = room
        return room

    def find_near(self, slave: Floats, master: Floats) -> Near:
        """Rebuild the near list for these positions of the surfaces (m, 2)."""
        near = super().find_near(slave, master)
        self.before.slave[:], self.before.master[:] = near.slave, near.master
        capacity = self.algorithm.capacity(self.slave, near.candidates)
        if capacity > len(self.pieces.slave):
            self.pieces = Pieces.allocate(capacity + capacity // 4, self.widths, self.slots)
            self._bind()
        self._unchecked = True
        return near

    # --- from coupling to rows ------------------------------------------------------------------

    def weights(self) -> BothSides:
        """Return weights of both sides' nodes in each constraint of the last update, computed on demand."""
        if not self._solved:
            slave, master = self._weights
            if self.coupling.table.single[0]:
                weight_kernels.own_nodes(self.coupling.bound.address, len(self.slave.nodes), slave)
            else:
                slave = weight_kernels.rows_of(self.coupling, self.columns.slave, slave)
            master = weight_kernels.rows_of(self.coupling, self.columns.master, master)
            if slave is not self._weights.slave or master is not self._weights.master:
                self._weights = BothSides(slave, master)
                self._bind()
            self._solved = True
        return self._weights

    def append_factored(self, out: FactoredRows) -> bool:
        """Append all constraints to `out`; False if `out` is too small."""
        count = kernels.write_factored(self.address, self.first_slot, out.count, out)
        if count >= 0:
            out.count = count
        return bool(count >= 0)

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`."""
        if self.everywhere or self.takes_rows:
            margin = FAR
        first = out.count
        self.weights()
        count, end = kernels.write_rows(
            self.address, min(margin, FAR), multipliers, self.first_slot, first, entries, out
        )
        if count < 0:
            return -1
        self._append_slips(out, first, count, current)
        out.count = count
        return self.take_rows(out, first, int(end))

    @property
    def takes_rows(self) -> bool:
        """True if `take_rows` changes rows, and needs all of them."""
        return False

    def take_rows(self, rows: Rows, first: int, entries: int) -> int:
        """Change rows from `first` on. Return the next free entry, or -1 without room."""
        return entries

    # --- from multipliers to pressures ----------------------------------------------------------

    def tractions(self, forces: Floats) -> Floats:
        """Return Lambda (k,) [MPa] = T^-1 y of nodal forces (k,) [N]: owner's value if merged, 0 without overlap."""
        return self.coupling.solve(forces)

    def snapshot(self, state: State, position: Floats) -> ContactSnapshot:
        """Return the snapshot of every pair, with nodal forces from forces at corners of the master."""
        seen = super().snapshot(state, position)
        return self._at_nodes(seen, state["multipliers"]) if self.holds_corners else seen

    def _at_nodes(self, seen: ContactSnapshot, multipliers: Floats) -> ContactSnapshot:
        return with_shares(self.slave, self.pieces, self.count, seen)

    @property
    def holds_corners(self) -> bool:
        """True if corners of the master have constraints whose forces reports show at the slave's nodes."""
        return isinstance(self.method, PointContact) and len(corner_pieces(self.pieces, self.count)) > 0


def _lump(T: Floats) -> None:
    """Replace T (p, k, k), or its derivatives, by the sums of its columns on the diagonal: the strong cone."""
    sums, k = T.sum(axis=1), np.arange(T.shape[1])
    T[:] = 0.0
    T[:, k, k] = sums


def refuse_wrong(pieces: Pieces, count: Any, slave_nodes: int, master_nodes: int, part: str) -> None:
    """Raise WrongAnswer if the first `count` pieces of a plugin component break the contract."""
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
