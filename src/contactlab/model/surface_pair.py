"""One contact pair at work: search, pieces, coupling, rows, and back to pressures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api import Candidates, ContactAlgorithm, Floats, FrictionLaw, Ints, Pieces, Rows, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.kernels import coupling, edges, rows
from contactlab.kernels.search import near_segments

REACH = 2.0  # segment lengths: farther slave segments are left out of the integrals
SKIN = 0.5  # segment lengths that surfaces may move before the near lists are made anew


@dataclass
class Near:
    """A near list and the positions it was made for."""

    candidates: Candidates
    slave: Floats
    master: Floats


class SurfacePair:
    """A slave and a master surface under one `ContactAlgorithm`.

    Multiplier k = slot * m + i of the pair lives at `first_slot + k` of the state's multipliers.
    """

    def __init__(
        self,
        name: str,
        algorithm: ContactAlgorithm,
        slave: Surface,
        master: Surface,
        reference: Floats,
        first_slot: int,
        friction: FrictionLaw | None,
        fixed: Floats,
    ) -> None:
        self.name = name
        self.algorithm, self.slave, self.master = algorithm, slave, master
        self.first_slot, self.friction = first_slot, friction
        m, slots = len(slave.nodes), algorithm.rows_per_node
        self.slots = slots * m
        self.at = SurfacePositions(reference[slave.nodes], reference[master.nodes])
        self.measured = SurfacePositions(self.at.slave.copy(), self.at.master.copy())
        self.size = max(_lengths(self.at.slave, slave).max(), _lengths(self.at.master, master).max())
        self.following, self.preceding = _neighbours(slave, slots)
        self.fixed = np.tile(fixed, slots)
        self.near: Near | None = None
        k = self.slots
        self.diagonal, self.lower, self.upper, self.cover = (np.zeros(k) for _ in range(4))
        self.from_left, self.from_right, self.factors, self.full = (np.zeros(k) for _ in range(4))
        self.owner, self.next, self.previous, self.order, self.members = (np.zeros(k, np.int32) for _ in range(5))
        self.separation, self.gaps = np.zeros((k, 2)), np.full((k, 2), np.nan)
        self.wanted = np.zeros(k, np.bool_)
        self.kept = 0
        self.count = 0
        self._room(0)

    # --- from positions to coupling -------------------------------------------------------------

    def update(self, positions: Floats, memory: Floats) -> None:
        """Search, integrate and factorise at `positions` (N, 2)."""
        edges.take(positions, self.slave.nodes, self.at.slave)
        edges.take(positions, self.master.nodes, self.at.master)
        candidates = self._candidates()
        reach = REACH * self.size
        self.count = self.algorithm.pieces(self.slave, self.master, self.at, candidates, reach, memory, self.pieces)
        self._couple()

    def measure(self, positions: Floats) -> None:
        """Separations and gaps of all kept multipliers at `positions`, with the rows of the last `update`."""
        edges.take(positions, self.slave.nodes, self.measured.slave)
        edges.take(positions, self.master.nodes, self.measured.master)
        p = self.pieces
        self.separation[:] = 0.0
        for (start, node, value, _, _, end), at, sign in (
            (self.slave_columns, self.measured.slave, 1.0),
            (self.master_columns, self.measured.master, -1.0),
        ):
            rows.weighted_positions(self.kept, self.order, start, end, node, value, at, sign, self.separation)
        coupling.solve_transposed(
            self.kept, self.order, self.lower, self.upper, self.next, self.previous, self.from_left, self.separation
        )
        rows.gaps_from_separation(self.kept, self.order, self.separation, p.normal, self.gaps)

    def _candidates(self) -> Candidates:
        near, skin = self.near, SKIN * self.size
        if (
            near is None
            or edges.largest_move(self.at.slave, near.slave) > skin
            or edges.largest_move(self.at.master, near.master) > skin
        ):
            reach = (REACH + 1.0) * self.size + 2.0 * skin
            found = near_segments(self.at.slave, self.slave.segments, self.at.master, self.master.segments, reach)
            self.near = near = Near(found, self.at.slave.copy(), self.at.master.copy())
            capacity = self.algorithm.capacity(self.slave, found)
            if capacity > len(self.pieces.slave):
                self._room(capacity + capacity // 4)
        return near.candidates

    def _room(self, capacity: int) -> None:
        s, k, r = widths = self.algorithm.widths(self.slave, self.master)
        self.pieces = Pieces.allocate(capacity, widths, self.slots)
        self.slave_columns = _columns(self.slots, capacity * s * k, len(self.slave.nodes))
        self.master_columns = _columns(self.slots, capacity * r * k, len(self.master.nodes))

    def _couple(self) -> None:
        p = self.pieces
        edges.tributary_lengths(self.at.slave, self.slave.segments, self.slave.node_segments, self.full)
        coupling.accumulate(
            self.count, p.multiplier, p.T, self.following, self.diagonal, self.lower, self.upper, self.cover
        )
        coupling.settle(
            self.full, self.fixed, self.following, self.preceding, self.diagonal, self.lower, self.upper,
            self.cover, self.owner, self.next, self.previous,
        )  # fmt: skip
        self.kept = coupling.factorise(
            self.diagonal, self.lower, self.upper, self.owner, self.next, self.previous,
            self.from_left, self.from_right, self.order,
        )  # fmt: skip
        if self.kept < 0:
            raise ValueError(f"{self.name}: the slave is a closed curve covered all around; swap slave and master")
        for nodes, values, (start, node, value, weight, _, end) in (
            (p.slave, p.D, self.slave_columns),
            (p.master, p.M, self.master_columns),
        ):
            rows.columns(self.count, p.multiplier, nodes, values, self.owner, start, node, value, weight, end)


    # --- from coupling to rows ------------------------------------------------------------------

    def append_rows(
        self, out: Rows, entries: int, margin: float, multipliers: Floats, before: Floats, current: Floats
    ) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`.

        Returns the next free entry, or -1 where `out` is too small. `before` are the normals at the
        start of the step, `current` the positions there (empty without friction).
        """
        with np.errstate(invalid="ignore"):
            np.less(self.gaps[:, 0], margin, out=self.wanted)
        self.wanted |= multipliers[0, self.first_slot : self.first_slot + self.slots] > 0.0
        first = out.count
        count, end = rows.emit_rows(
            self.kept, self.order, self.wanted,
            (self.diagonal, self.lower, self.upper, self.next, self.previous,
             self.from_left, self.from_right, self.members, self.factors),
            _row_side(self.slave_columns, self.slave.nodes),
            _row_side(self.master_columns, self.master.nodes),
            self.pieces.normal, before, current,
            (out.node, out.normal_weight, out.tangent_weight), first, entries,
            (out.start, out.gap, out.slip, out.measure, out.size, out.slot,
             self.gaps, self.cover, self.full, self.first_slot),
        )  # fmt: skip
        if count < 0:
            return -1
        if self.friction is not None:
            out.bound[:, first:count] = np.array(self.friction.bound())[:, None]
        out.count = count
        return int(end)

    # --- from multipliers to pressures ----------------------------------------------------------

    def tractions(self, forces: Floats) -> Floats:
        """Lambda (k,) [MPa] from nodal forces y (k,) [N]: T^-1 y, the owner's value where merged, 0 off cover."""
        values = np.array(forces)
        coupling.solve(
            self.kept, self.order, self.lower, self.upper, self.next, self.previous, self.from_left, values
        )
        return np.where(self.owner >= 0, values[self.owner], 0.0)


def _columns(multipliers: int, entries: int, nodes: int) -> tuple[Ints, Ints, Floats, Floats, Ints, Ints]:
    """Room for compressed columns: start, node, value, weight, touched, end."""
    return (
        np.zeros(multipliers + 1, np.int32),
        np.zeros(entries, np.int32),
        np.zeros(entries),
        np.zeros(nodes),
        np.zeros(nodes, np.int32),
        np.zeros(multipliers, np.int32),
    )


def _row_side(columns: tuple[Ints, Ints, Floats, Floats, Ints, Ints], numbers: Ints) -> tuple:
    start, node, value, weight, touched, end = columns
    return start, end, node, value, weight, touched, numbers


def _lengths(positions: Floats, surface: Surface) -> Floats:
    edge = positions[surface.segments[:, 1]] - positions[surface.segments[:, 0]]
    return np.asarray(np.hypot(edge[:, 0], edge[:, 1]))


def _neighbours(slave: Surface, slots: int) -> tuple[Ints, Ints]:
    """For every multiplier the ones of the next and of the previous chain node, -1 at ends."""
    m = len(slave.nodes)
    into, out = slave.node_segments[:, 0], slave.node_segments[:, 1]
    following = np.where(out >= 0, slave.segments[out, 1], -1)
    preceding = np.where(into >= 0, slave.segments[into, 0], -1)
    shift = m * np.arange(slots)[:, None]
    both = [np.where(side >= 0, side + shift, -1).ravel().astype(np.int32) for side in (following, preceding)]
    return both[0], both[1]
