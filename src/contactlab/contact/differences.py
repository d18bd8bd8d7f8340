"""Derivatives of a contact algorithm's pieces by central differences, for algorithms that give none."""

from __future__ import annotations

import numpy as np

from contactlab.api import ContactView, Floats, Ints, Pieces
from contactlab.api.arrays import Flags
from contactlab.api.derivatives import PieceDerivatives
from contactlab.api.surface import SurfacePositions
from contactlab.contact.operator_pair import OperatorPair
from contactlab.kernels.contact import differences as kernels
from contactlab.kernels.contact.coupling import links

STEP = 1e-5  # segment lengths; central differences of smooth pieces then err by about 1e-10
RING = 2  # further nodes on both sides of a piece that it may depend on by averaged normals


class Differences:
    """Derivatives of a pair's pieces, by moving the nodes of one colour at a time."""

    def __init__(self, pair: OperatorPair) -> None:
        self.pair = pair
        self.links = links(pair.slave), links(pair.master)
        self.high, self.low = self._spare(), self._spare()
        self.follows_master: bool | None = None
        self.shown: tuple[ContactView, ...] = ()

    def _spare(self) -> Pieces:
        return Pieces.allocate(len(self.pair.pieces.slave), self.pair.widths, self.pair.slots)

    def of(self, memory: Floats) -> PieceDerivatives:
        """Return derivatives at the pair's present positions."""
        pair = self.pair
        if len(self.high.slave) < len(pair.pieces.slave):
            self.high, self.low = self._spare(), self._spare()
        self._look(memory)
        owners = self._owners(memory)
        # upper limit of coordinates per piece; unmatched pieces stand twice
        width = 2 * sum(_period(nodes[: pair.count]) for nodes in (pair.pieces.slave, pair.pieces.master))
        entries, normals = 2 * (pair.count + 8) * width, 2 * pair.slots * sum(_period(o) for o in owners)
        out = pair.room_for_derivatives(entries, normals)
        out.count = out.normal_count = 0
        for side in range(2):
            self._side(side, owners[side], memory, out)
        return out

    def _owners(self, memory: Floats) -> tuple[Ints, Ints]:
        """Return surface nodes on both sides that the normal of each multiplier may depend on."""
        pair = self.pair
        m = len(pair.slave.nodes)
        slave = (np.arange(pair.slots, dtype=np.int32) % m)[:, None]
        first, last = np.full(pair.slots, np.iinfo(np.int32).max, np.int32), np.full(pair.slots, -1, np.int32)
        if self.follows_master is None:
            self.follows_master = self._probe(memory)
        if self.follows_master:
            multiplier, nodes = pair.pieces.multiplier[: pair.count], pair.pieces.master[: pair.count]
            np.minimum.at(first, multiplier, nodes.min(axis=1, keepdims=True))
            np.maximum.at(last, multiplier, nodes.max(axis=1, keepdims=True))
        return slave, np.stack([np.minimum(first, last), last], axis=1)

    def _probe(self, memory: Floats) -> bool:
        """Return whether normals change with the master's positions."""
        pair = self.pair
        shake = np.random.default_rng(1).uniform(-STEP, STEP, pair.at.master.shape) * pair.size
        self.shown[0].at.master[:] += shake
        self._evaluate(0, memory)
        self.shown[0].at.master[:] = pair.at.master
        self._evaluate(1, memory)
        return not np.array_equal(self.high.normal, self.low.normal)

    def _side(self, side: int, owners: Ints, memory: Floats, out: PieceDerivatives) -> None:
        pair = self.pair
        nodes = (pair.pieces.slave, pair.pieces.master)[side]
        colours = _colours(
            len((pair.slave, pair.master)[side].nodes), max(_period(nodes[: pair.count]), _period(owners))
        )
        shift, step = side * len(pair.slave.nodes), STEP * pair.size
        entries = (out.slave, out.multiplier, out.master, out.moved, out.dD, out.dM, out.dT)
        normals = (out.normal_of, out.normal_moved, out.dnormal)
        for colour in range(int(colours.max()) + 1):
            for direction in range(2):
                move = kernels.Move(*self.links[side], colours, RING, shift, colour, direction, 0.5 / step)
                high_count = self._moved(0, side, colours == colour, direction, step, memory)
                low_count = self._moved(1, side, colours == colour, direction, -step, memory)
                out.count = kernels.differences(
                    high_count, _arrays(self.high), low_count, _arrays(self.low), 2 * side, move, out.count, entries
                )
                out.normal_count = kernels.normal_differences(
                    self.high.normal, pair.pieces.normal, self.low.normal, owners, move, out.normal_count, normals
                )

    def _look(self, memory: Floats) -> None:
        """Make two views with positions and memory of their own, one for each side of a difference.

        They stay the same objects for all differences of a call, so that an algorithm binds its arrays to them once.
        """
        seen = self.pair.seen(memory)
        self.shown = tuple(
            seen._replace(at=SurfacePositions(*(x.copy() for x in seen.at)), memory=memory.copy()) for _ in range(2)
        )

    def _moved(self, which: int, side: int, chosen: Flags, direction: int, step: float, memory: Floats) -> int:
        """Compute pieces with some nodes moved, into `high` or `low`, and restore the positions."""
        at, kept = self.shown[which].at[side], self.pair.at[side]
        at[chosen, direction] += step
        count = self._evaluate(which, memory)
        at[chosen, direction] = kept[chosen, direction]
        return count

    def _evaluate(self, which: int, memory: Floats) -> int:
        view, out = self.shown[which], (self.high, self.low)[which]
        out.normal[:] = self.pair.pieces.normal
        view.memory[:] = memory
        return self.pair.algorithm.pieces(view, out)


def _arrays(pieces: Pieces) -> tuple[Ints, Ints, Ints, Floats, Floats, Floats]:
    return pieces.slave, pieces.multiplier, pieces.master, pieces.D, pieces.M, pieces.T


def _period(nodes: Ints) -> int:
    """Return how many neighbours on a chain need different colours so that no piece depends on two of one colour."""
    used = nodes[nodes[:, 0] >= 0] if len(nodes) else nodes
    if not len(used):
        return 1 + 2 * RING
    span = used.max(axis=1) - used.min(axis=1)
    # a piece across the start of a closed chain spans almost the whole chain
    inner = span[span <= max(used.shape[1], (int(used.max()) + 1) // 2)]
    return int(inner.max(initial=0)) + 1 + 2 * RING


def _colours(nodes: int, period: int) -> Ints:
    """Return colours that repeat with `period`; the remainder at the end of a chain gets colours of its own."""
    whole = nodes - nodes % period
    colours = np.arange(nodes) % period
    colours[whole:] = period + np.arange(nodes - whole)
    return colours.astype(np.int32)
