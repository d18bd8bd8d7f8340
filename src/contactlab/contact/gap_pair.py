"""A contact pair whose algorithm gives finished gap constraints."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contactlab.api import ContactView, Floats, FrictionLaw, GapAlgorithm, GapConditions, Rows, Surface
from contactlab.api.compiled.chains import tributary_lengths
from contactlab.contact.examination import copies, refuse_written
from contactlab.contact.pair import ContactPair
from contactlab.errors import WrongAnswer
from contactlab.kernels.contact.pair import FAR
from contactlab.kernels.contact.search import take


class GapPair(ContactPair):
    """A slave and a master surface under one `GapAlgorithm`.

    found     constraints of the last `update`, made_at (N, 2) [mm] their positions
    of_slave  (N,) True for nodes of the slave
    """

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
        super().__init__(name, algorithm, slave, master, reference, first_slot, friction)
        self.algorithm, k = algorithm, self.slots
        self.full, self.cover, self.normals = np.zeros(k), np.zeros(k), np.zeros((k, 2))
        self.made_at = reference.copy()
        self.of_slave = np.zeros(len(reference), np.bool_)
        self.of_slave[slave.nodes] = True
        self.found: GapConditions | None = None

    def calls_per_step(self) -> dict[str, int]:
        """Count constraints once, and twice with friction, for the start of the step."""
        return {"contact conditions": 1 + int(self.friction is not None)}

    # --- from positions to constraints -----------------------------------------------------------

    def update(self, positions: Floats, memory: Floats) -> None:
        """Compute the constraints at `positions` (N, 2), and measure their gaps there."""
        take(positions, self.slave.nodes, self.at.slave)
        take(positions, self.master.nodes, self.at.master)
        tributary_lengths(self.at.slave, self.slave.segments, self.slave.node_segments, self.full)
        if self.near is None or not self.near.holds(self.at, self.size):
            self.find_near(self.at.slave, self.at.master)
        first = self.found is None
        view = self.seen(memory)
        before = copies(view) if first else {}
        found = self.ask(view)
        if before:
            refuse_written(view, before, self.algorithm, "conditions")
        if first or _doubtful(found):
            refuse_wrong(found, self.slots, len(positions), self.friction is not None, type(self.algorithm).__name__)
        self.found = found
        self.made_at[:] = positions
        self.cover[:] = 0.0
        self.cover[found.owner] = found.measure
        self.normals[found.owner] = self._directions(found)
        self.compute_gaps(positions)

    def update_pushed(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """Call `update` at predicted + compliance * force, all (N, 2), and measure gaps at `predicted`."""
        self.update(predicted + compliance * force, memory)
        self.compute_gaps(predicted)

    def ask(self, view: ContactView) -> GapConditions:
        """Return the algorithm's constraints for a view, with tangent weights if the contact has friction."""
        return self.algorithm.conditions(view, tangent=self.friction is not None)

    def gaps_at(self, positions: Floats) -> Floats:
        """Return gaps (k, 2) at `positions` with the weights of the last `update`, in a new array."""
        assert self.found is not None
        found, gaps = self.found, self.gaps.copy()
        moved = positions[found.node] - self.made_at[found.node]
        gaps[:, 0] = FAR
        gaps[found.owner, 0] = found.gap + _per_row(found, found.normal_weight, moved)
        if self.friction is not None:
            gaps[found.owner, 1] = _per_row(found, found.tangent_weight, positions[found.node])
        return gaps

    def compute_start_normals(self, positions: Floats, memory: Floats) -> None:
        """Compute normals at `positions`, the start of the step (friction only); unchanged if there are none."""
        assert self.sliding is not None
        found = self.ask(self._start(positions, memory)._replace(memory=memory.copy()))
        self.sliding.before[:] = self.normals
        self.sliding.before[found.owner] = self._directions(found)

    def _directions(self, found: GapConditions) -> Floats:
        """Return unit vectors (k, 2) of the force on the slave in each constraint."""
        if not len(found.gap):
            return np.zeros((0, 2))
        own = np.where(self.of_slave[found.node, None], found.normal_weight, 0.0)
        total = np.add.reduceat(own, found.start[:-1], axis=0)
        return np.asarray(total / np.hypot(total[:, 0], total[:, 1])[:, None])

    # --- from constraints to rows ----------------------------------------------------------------

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`."""
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
        if len(out.tangent_weight):
            out.tangent_weight[entries:end] = found.tangent_weight[taken] if self.friction is not None else 0.0
        self._append_slips(out, first, last, current)
        out.count = last
        return end

    # --- from multipliers to pressures ----------------------------------------------------------

    def tractions(self, forces: Floats) -> Floats:
        """Return Lambda (k,) [MPa] of nodal forces y (k,) [N]: force per length of the constraint."""
        return np.divide(forces, self.cover, out=np.zeros_like(forces), where=self.cover > 0.0)


def _per_row(found: GapConditions, weight: Floats, vectors: Floats) -> Floats:
    """Return the sum over each row of weight . vector (z, 2)."""
    if not len(found.gap):
        return np.zeros(0)
    return np.asarray(np.add.reduceat(np.einsum("zi,zi->z", weight, vectors), found.start[:-1]))


def _doubtful(found: Any) -> bool:
    """Return whether constraints of a later step need a full check: cheap signs of errors."""
    if type(found) is not GapConditions:
        return True
    k, z = len(found.gap), len(found.node)
    if not len(found.owner) == len(found.measure) == len(found.start) - 1 == k or len(found.normal_weight) != z:
        return True
    return not math.isfinite(found.gap.sum() + found.normal_weight.sum() + found.measure.sum())


def refuse_wrong(found: Any, slave_nodes: int, nodes: int, tangent: bool, part: str) -> None:
    """Raise WrongAnswer with the part of a plugin component's gap constraints that breaks the contract."""
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
