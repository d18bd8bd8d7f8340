"""Derivatives of finished gap constraints by central differences, for algorithms that give none.

Nodes that share no constraint are moved together (Curtis, Powell & Reid 1974). Constraints depend on more nodes than
they name: the pattern is guessed, tested by moving all nodes together, and widened if the test shows more.
"""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array

from contactlab.api import ConditionDerivatives, Floats, GapConditions, Ints
from contactlab.api.surface import SurfacePositions
from contactlab.contact.gap_pair import GapPair

STEP = 1e-5  # of the shortest segment at a node; central differences of smooth weights then err by about 1e-10
ROUND_OFF = 1e-10  # of a weight over a segment length: result of differences for a zero derivative
RING = 2  # further nodes on both sides that a constraint may depend on by averaged normals
KINK = 1e-3  # difference of the slopes on both sides: smooth weights bend by a few steps
MISSED = 1e-6  # of a weight over a segment length, along one move of all nodes: far above the error of differences


class ConditionDifferences:
    """Central differences that move the nodes of one colour at a time."""

    def __init__(self, pair: GapPair) -> None:
        self.pair = pair
        self.reach = _reach(pair)
        self.size = _sizes(pair)
        self.colours: dict[int, _Colours] = {}  # by the number of widenings of the pattern
        self.at_once = np.random.default_rng(0).uniform(-1.0, 1.0, (len(pair.of_slave), 2))

    def of(self, memory: Floats) -> ConditionDerivatives:
        """Return derivatives of the weights of the pair's present constraints."""
        found = self.pair.found
        assert found is not None
        if not len(found.owner):
            return ConditionDerivatives(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2)))
        order, row = _order(found), np.repeat(np.arange(len(found.owner)), np.diff(found.start))
        named = coo_array((np.ones(len(row)), (row, found.node)), shape=(len(found.owner), self.reach.shape[0]))
        depends = _pattern(named.tocsr() @ self.reach)  # nodes (k, N) of constraints, and their neighbours
        sides = [self._weights(found, order, sign * self.at_once, memory) for sign in (1.0, -1.0)]
        for width in count():
            known, pattern = self.colours.get(width), (depends.indptr, depends.indices)
            if known is None or not all(map(np.array_equal, known.pattern, pattern)):
                self.colours[width] = _Colours(depends)
            derivatives = self._of_colours(self.colours[width], found, order, memory)
            wider = self._wider(depends)
            if wider.nnz == depends.nnz or self._tells_all(derivatives, order, sides):
                break
            depends = wider
        return derivatives

    def _of_colours(self, colours: _Colours, found: GapConditions, order: Ints, memory: Floats) -> ConditionDerivatives:
        """Return differences with the nodes of one colour moved at a time, along each axis."""
        row = np.repeat(np.arange(len(found.owner)), np.diff(found.start))
        here = found.normal_weight[order]
        entries, moved, values = [], [], []
        for number, chosen in enumerate(colours.members):
            node = colours.node[row, number]
            for direction, axis in enumerate(np.eye(2)):
                move = chosen[:, None] * axis
                high, low = (self._weights(found, order, sign * move, memory) for sign in (1.0, -1.0))
                size = self.size[node][:, None]
                value = _difference(high, here, low, STEP * size)
                kept = np.flatnonzero((node >= 0) & np.any(np.abs(value) > ROUND_OFF / size, axis=1))
                entries.append(order[kept])
                moved.append(2 * node[kept] + direction)
                values.append(value[kept])
        return ConditionDerivatives(np.concatenate(entries), np.concatenate(moved), np.concatenate(values))

    def _weights(self, found: GapConditions, order: Ints, move: Floats, memory: Floats) -> Floats:
        """Return sorted normal weights (z, 2), with nodes moved by `move` (N, 2) of their steps; NaN if nodes vary."""
        pair = self.pair
        by = STEP * self.size[:, None] * move
        at = SurfacePositions(pair.at.slave + by[pair.slave.nodes], pair.at.master + by[pair.master.nodes])
        return _aligned(found, order, pair.ask(pair.seen(memory)._replace(at=at, memory=memory.copy())), pair.slots)

    # --- nodes that constraints depend on --------------------------------------------------------------

    def _wider(self, depends: csr_array) -> csr_array:
        """Return the pattern extended to constraints that share a node; all nodes of both surfaces if this adds none.

        Rows of a mortar with inverted T name one slave node, and depend on all nodes that face their masters.
        """
        wider = _pattern(depends @ depends.T @ depends)
        if wider.nnz > depends.nnz:
            return wider
        of_either = np.zeros(depends.shape[1])
        of_either[self.pair.slave.nodes] = of_either[self.pair.master.nodes] = 1.0
        return _pattern(csr_array(np.ones((depends.shape[0], 1)) * of_either))

    def _tells_all(self, given: ConditionDerivatives, order: Ints, sides: list[Floats]) -> bool:
        """Return whether derivatives reproduce the change of weights as all nodes move; kinks are ignored."""
        along, moves = np.zeros((len(order), 2)), (self.size[:, None] * self.at_once).ravel()
        np.add.at(along, given.entry, given.value * moves[given.moved, None])
        missed = np.abs((sides[0] - sides[1]) / (2.0 * STEP) - along[order])
        here = self.pair.found.normal_weight[order]  # type: ignore[union-attr]
        bent = np.abs(sides[0] + sides[1] - 2.0 * here) > KINK * STEP
        return not bool(np.any((missed > MISSED) & ~bent))  # NaN, for other nodes, is no miss


class _Colours:
    """Colours of all nodes that a constraint (row) depends on, all different within a constraint; greedily.

    node (k, colours) of each constraint and colour or -1, masks (N,) of the `members` of each colour
    """

    def __init__(self, depends: csr_array) -> None:
        self.pattern = depends.indptr, depends.indices
        nodes = depends.shape[1]
        conflict = csr_array(depends.T @ depends)
        colour = np.full(nodes, -1)
        for node in np.unique(depends.indices):
            taken = set(colour[conflict.indices[conflict.indptr[node] : conflict.indptr[node + 1]]].tolist())
            colour[node] = next(number for number in range(nodes) if number not in taken)
        count = int(colour.max(initial=-1)) + 1
        self.node = np.full((depends.shape[0], count), -1)
        row = np.repeat(np.arange(depends.shape[0]), np.diff(depends.indptr))
        self.node[row, colour[depends.indices]] = depends.indices
        self.members = tuple(colour == number for number in range(count))


def _pattern(product: Any) -> csr_array:
    """Return the sorted pattern of nonzeros of a product."""
    found = csr_array(product)
    found.sort_indices()
    found.data[:] = 1.0
    return found


def _reach(pair: GapPair) -> csr_array:
    """Return (N, N) the nodes that a constraint on a node may depend on: `RING` neighbours along both surfaces."""
    nodes = len(pair.of_slave)
    links = eye_array(nodes, format="csr")
    for surface in (pair.slave, pair.master):
        a, b = surface.nodes[surface.segments].T
        both = np.concatenate([a, b]), np.concatenate([b, a])
        links = links + coo_array((np.ones(2 * len(a)), both), shape=(nodes, nodes)).tocsr()
    reach = links
    for _ in range(RING - 1):
        reach = reach @ links
    return csr_array(reach)


def _order(found: GapConditions) -> Ints:
    """Return entries sorted by node within each constraint."""
    row = np.repeat(np.arange(len(found.owner)), np.diff(found.start))
    return np.lexsort((found.node, row)).astype(np.int32)


def _aligned(found: GapConditions, order: Ints, trial: GapConditions, slots: int) -> Floats:
    """Return weights of a trial's constraints at the entries (z,) of `found`, in order; NaN if its nodes differ."""
    out = np.full((len(order), 2), np.nan)
    place = np.full(slots, -1)
    place[trial.owner] = np.arange(len(trial.owner))
    width, theirs = np.diff(found.start), np.append(np.diff(trial.start), 0)
    same = (place[found.owner] >= 0) & (theirs[place[found.owner]] == width)
    row = np.repeat(np.arange(len(width)), width)
    kept = np.flatnonzero(same[row])
    if not len(kept):
        return out
    within = np.arange(len(order)) - found.start[:-1][row]
    entry = _order(trial)[trial.start[place[found.owner[row[kept]]]] + within[kept]]
    differs = found.node[order[kept]] != trial.node[entry]
    out[kept] = trial.normal_weight[entry]
    out[np.isin(row, row[kept[differs]])] = np.nan
    return out


def _sizes(pair: GapPair) -> Floats:
    """Return the length (N,) [mm] of the shortest segment at each node: graded meshes vary a hundredfold."""
    size = np.full(len(pair.of_slave), np.inf)
    for surface, at in ((pair.slave, pair.at.slave), (pair.master, pair.at.master)):
        ends = at[surface.segments]
        length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
        for end in surface.segments.T:
            np.minimum.at(size, surface.nodes[end], length)
    return np.where(np.isfinite(size), size, pair.size)


def _difference(high: Floats, here: Floats, low: Floats, step: Floats) -> Floats:
    """Return the central difference; one-sided if the other side lies beyond a kink, zero if both do."""
    value = (high - low) / (2.0 * step)
    value = np.where(np.isnan(low), (high - here) / step, value)
    value = np.where(np.isnan(high), (here - low) / step, value)
    return np.nan_to_num(value)
