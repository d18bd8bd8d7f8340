"""One contact pair whose algorithm gives finished gap conditions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contactlab.api import Candidates, Floats, FrictionLaw, GapAlgorithm, GapConditions, Ints, Rows, Surface
from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.surface import SurfacePositions
from contactlab.errors import WrongAnswer
from contactlab.kernels.contact import edges, rows
from contactlab.kernels.contact.factored_rows import FAR
from contactlab.kernels.contact.warm_start import displaced
from contactlab.model.contact.near_list import REACH, Near, longest_segment
from contactlab.model.contact.operator_pair import SurfacePair


class GapPair:
    """A slave and a master surface under one `GapAlgorithm`; the same interface as `SurfacePair`.

    The multiplier of slave node i lives at `first_slot + i` of the state's multipliers.
    """

    rows_per_node = 1
    factored = False  # conditions come finished
    kept = 0
    between = (np.zeros(0, np.int32),) * 3  # every slave node may have a condition

    def __init__(
        self,
        name: str,
        algorithm: GapAlgorithm,
        slave: Surface,
        master: Surface,
        reference: Floats,
        first_slot: int,
        friction: FrictionLaw | None,
    ) -> None:
        self.name, self.algorithm, self.slave, self.master = name, algorithm, slave, master
        self.first_slot, self.friction = first_slot, friction
        self.slots = m = len(slave.nodes)
        self.at = SurfacePositions(reference[slave.nodes], reference[master.nodes])
        self.size = longest_segment(self.at, slave, master)
        self.near: Near | None = None
        self.full, self.cover = np.zeros(m), np.zeros(m)
        self.gaps, self.normals = np.full((m, 2), FAR), np.zeros((m, 2))
        self.updated: Floats = reference.copy()
        self.pushed: Floats = reference.copy()
        self.of_slave = np.zeros(len(reference), np.bool_)
        self.of_slave[slave.nodes] = True
        self.found: GapConditions | None = None
        self.everywhere = False
        if friction is not None:
            bound = friction.bound()
            self.bound = np.array(bound)
            self.everywhere = bound.adhesion > 0.0 and not math.isfinite(bound.cap)
            self.before = np.zeros((m, 2))

    # --- from positions to conditions -----------------------------------------------------------

    def update(self, positions: Floats, memory: Floats) -> None:
        """Ask for the conditions at `positions` (N, 2); nothing is remembered between steps."""
        del memory
        edges.take(positions, self.slave.nodes, self.at.slave)
        edges.take(positions, self.master.nodes, self.at.master)
        tributary_lengths(self.at.slave, self.slave.segments, self.slave.node_segments, self.full)
        first = self.found is None
        found = self._conditions(self.at)
        if first or _doubtful(found):
            refuse_wrong(found, self.slots, len(positions), self.friction is not None, type(self.algorithm).__name__)
        self.found = found
        self.updated[:] = positions
        self.kept = len(found.gap)
        self.cover[:] = 0.0
        self.cover[found.owner] = found.measure
        self.normals[found.owner] = self._normals(found)

    def follow(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """`update` at predicted + compliance * force, all (N, 2), and `measure` at `predicted`."""
        displaced(predicted, compliance, force, self.pushed)
        self.update(self.pushed, memory)
        self.measure(predicted)

    def _conditions(self, at: SurfacePositions) -> GapConditions:
        near, tangent = self._candidates(), self.friction is not None
        return self.algorithm.conditions(self.slave, self.master, at, near, REACH * self.size, tangent=tangent)

    def measure(self, positions: Floats) -> None:
        """Gaps at `positions`, with the weights of the last `update`."""
        assert self.found is not None
        found = self.found
        moved = positions[found.node] - self.updated[found.node]
        self.gaps[:, 0] = FAR
        self.gaps[found.owner, 0] = found.gap + _per_row(found, found.normal_weight, moved)
        if self.friction is not None:
            self.gaps[found.owner, 1] = _per_row(found, found.tangent_weight, positions[found.node])
        self.settle()

    def settle(self) -> None:
        """What is done to gaps that were just measured: nothing, but for pairs that take overlaps back."""

    def begin(self, positions: Floats, memory: Floats) -> None:
        """Normals at `positions`, where the step starts (friction only); unchanged where there were none."""
        del memory
        sides = SurfacePositions(positions[self.slave.nodes], positions[self.master.nodes])
        found = self._conditions(sides)
        self.before[:] = self.normals
        self.before[found.owner] = self._normals(found)

    def _normals(self, found: GapConditions) -> Floats:
        """Unit vectors (k, 2): what each condition pushes its slave with."""
        if not len(found.gap):
            return np.zeros((0, 2))
        own = np.where(self.of_slave[found.node, None], found.normal_weight, 0.0)
        total = np.add.reduceat(own, found.start[:-1], axis=0)
        return np.asarray(total / np.hypot(total[:, 0], total[:, 1])[:, None])

    def _candidates(self) -> Candidates:
        near = self.near
        if near is None or not near.holds(self.at, self.size):
            near = self.find_near(self.at.slave, self.at.master)
        return near.candidates

    def find_near(self, slave: Floats, master: Floats) -> Near:
        """Make the near list anew, for these positions of the surfaces (m, 2)."""
        self.near = Near.of(self.slave, self.master, slave, master, self.size)
        return self.near

    # --- from conditions to rows ----------------------------------------------------------------

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force; returns the next free entry, -1 out of room."""
        found, first = self.found, out.count
        assert found is not None
        near = self.gaps[found.owner, 0] < (FAR if self.everywhere else margin)
        chosen = np.flatnonzero(near | (multipliers[0, self.first_slot + found.owner] > 0.0))
        width = np.diff(found.start)[chosen]
        ends = entries + np.cumsum(width)
        last, end = first + len(chosen), int(ends[-1]) if len(ends) else entries
        if last > len(out.gap) or end > len(out.node):
            return -1
        out.start[first] = entries
        out.start[first + 1 : last + 1] = ends
        # entry numbers of the chosen rows, one row after another
        taken = np.repeat(found.start[chosen] - (ends - width - entries), width) + np.arange(end - entries)
        out.node[entries:end], out.normal_weight[entries:end] = found.node[taken], found.normal_weight[taken]
        owner = found.owner[chosen]
        out.gap[first:last], out.measure[first:last] = self.gaps[owner, 0], found.measure[chosen]
        out.size[first:last], out.slot[first:last] = self.full[owner], self.first_slot + owner
        self._append_slips(out, first, last, slice(entries, end), taken.astype(np.int32), current)
        out.count = last
        return end

    def _append_slips(self, out: Rows, first: int, last: int, own: slice, taken: Ints, current: Floats) -> None:
        if not len(out.slip):
            return
        if self.friction is None:
            out.bound[:, first:last], out.slip[first:last], out.tangent_weight[own] = 0.0, 0.0, 0.0
            return
        assert self.found is not None
        out.bound[:, first:last] = self.bound[:, None]
        out.tangent_weight[own] = self.found.tangent_weight[taken]
        measured = self.gaps, self.normals, self.before
        rows.write_slips(first, last, self.first_slot, measured, current, out.packed.address)

    # --- from multipliers to pressures ----------------------------------------------------------

    def tractions(self, forces: Floats) -> Floats:
        """Lambda (k,) [MPa] from nodal forces y (k,) [N]: force per length that the condition stands for."""
        return np.divide(forces, self.cover, out=np.zeros_like(forces), where=self.cover > 0.0)


Pair = SurfacePair | GapPair
"""A pair at work, whichever way its algorithm is written."""


def _per_row(found: GapConditions, weight: Floats, vectors: Floats) -> Floats:
    """Sum over each row of weight . vector (z, 2)."""
    if not len(found.gap):
        return np.zeros(0)
    return np.asarray(np.add.reduceat(np.einsum("zi,zi->z", weight, vectors), found.start[:-1]))


def _doubtful(found: Any) -> bool:
    """Whether conditions of a later step have to be looked at more closely: cheap signs of what is wrong."""
    if type(found) is not GapConditions:
        return True
    k, z = len(found.gap), len(found.node)
    if not len(found.owner) == len(found.measure) == len(found.start) - 1 == k or len(found.normal_weight) != z:
        return True
    return not math.isfinite(found.gap.sum() + found.normal_weight.sum() + found.measure.sum())


def refuse_wrong(found: Any, slave_nodes: int, nodes: int, tangent: bool, part: str) -> None:
    """Raise WrongAnswer naming what of the gap conditions of a part is not as the contract says."""
    if not isinstance(found, GapConditions):
        raise WrongAnswer(f"{part}: conditions gave {type(found).__name__}, needed: GapConditions")
    k, z = len(found.gap), len(found.node)
    wanted = {
        "start": (k + 1,), "normal_weight": (z, 2), "tangent_weight": (z if tangent else 0, 2), "measure": (k,),
        "owner": (k,),
    }  # fmt: skip
    for name, shape in wanted.items():
        got = np.shape(getattr(found, name))
        if got != shape:
            raise WrongAnswer(f"{part}: {name} has the shape {got}, needed {shape} for {k} conditions of {z} entries")
    start, owner = np.asarray(found.start), np.asarray(found.owner)
    rules = {
        "start: row pointers from 0 to the number of entries, no row empty": k == 0
        or (start[0] == 0 and start[-1] == z and bool(np.all(np.diff(start) > 0))),
        f"node: global node numbers 0 to {nodes - 1}": z == 0 or 0 <= found.node.min() <= found.node.max() < nodes,
        f"owner: positions 0 to {slave_nodes - 1} in the slave surface": k == 0
        or 0 <= owner.min() <= owner.max() < slave_nodes,
        "gap, normal_weight, tangent_weight: finite numbers": all(
            bool(np.isfinite(values).all()) for values in (found.gap, found.normal_weight, found.tangent_weight)
        ),
        "owner: each slave node at most once": len(np.unique(owner)) == k,
        "measure: lengths > 0": bool(np.all(np.asarray(found.measure) > 0.0)),
    }
    for rule, kept in rules.items():
        if not kept:
            raise WrongAnswer(f"{part}: a gap condition is not as allowed: {rule}")
