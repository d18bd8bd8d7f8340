"""The work of normal contact forces in every step by its sources (docs/theory/contact-energy.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api import ExplicitIntegrator, Floats, Integrator, State, Step
from contactlab.api.arrays import Flags
from contactlab.api.integrator import LEAPFROG
from contactlab.api.state import CONTACT_WORK
from contactlab.api.surface import SurfacePositions
from contactlab.contact.consistent_system import ConstantColumns
from contactlab.contact.explicit_system import ContactSystem
from contactlab.contact.gradients import PairGradients
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.errors import SceneError, Where
from contactlab.kernels.contact.pair import FAR

SAVED = "work_split"
Instant = tuple[Floats, Floats]
"""Positions (N, 2) [mm], and the memory of an algorithm there (memory_size, m)."""


class WorkSplit:
    """Sums the parts of the contact work of one explicit leapfrog run; `sample` is called after every step.

    work      (4,) [mJ] the `CONTACT_WORK` so far; their sum is the contact entry of the energy balance
    position  (2, N, 2) [mm] at the start and the end of the last step
    velocity  (N, 2) [mm/s] after it; `last_dt` (1,) [s] its length, 0 before the first
    memory    of each pair's algorithm at both positions (2, memory_size, m)
    """

    def __init__(self, contact: ContactSystem, state: State, reference: Floats) -> None:
        self.contact, self.state, self.reference = contact, state, reference
        self.work, self.last_dt = np.zeros(len(CONTACT_WORK)), np.zeros(1)
        start = reference + state["displacement"]
        self.position, self.velocity = np.stack([start, start]), state["velocity"].copy()
        self.memory = [np.zeros((2, pair.method.memory_size, len(pair.slave.nodes))) for pair in contact.pairs]
        self.pairs = [
            OperatorSplit(pair, reference, contact.consistent)
            if isinstance(pair, OperatorPair)
            else PairSplit(pair, reference)
            for pair in contact.pairs
        ]

    def saved(self) -> Mapping[str, Floats]:
        """Return the arrays for a restart."""
        return {f"{SAVED}.{name}": array.copy() for name, array in self._arrays().items()}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Restore arrays that were `saved`."""
        for name, array in self._arrays().items():
            array[...] = memory[f"{SAVED}.{name}"]

    def _arrays(self) -> dict[str, Floats]:
        of_pairs = {pair.name: memory for pair, memory in zip(self.contact.pairs, self.memory, strict=True)}
        own = {"work": self.work, "position": self.position, "velocity": self.velocity, "last_dt": self.last_dt}
        return own | of_pairs

    def sample(self, step: Step, dt: float) -> None:
        """Book the step of length dt [s] that has just been made."""
        reached, velocity = self.reference + self.state["displacement"], self.state["velocity"]
        if self.contact.multipliers[0].any():
            # forces work with the mean velocity: on half of the path from `before` to the positions reached
            before = reached - 0.5 * (float(self.last_dt[0]) + dt) * (self.velocity + velocity)
            self._book(before, reached)
        self.position[0], self.position[1] = self.position[1], reached
        self.velocity[:], self.last_dt[0] = velocity, dt
        for memory, pair in zip(self.memory, self.contact.pairs, strict=True):
            memory[0], memory[1] = memory[1], pair.memory_in(self.state)

    def _book(self, before: Floats, reached: Floats) -> None:
        left, force = self.position[0], self._normal_force()
        moved, parts, frozen, turned = reached - left, np.zeros(len(CONTACT_WORK)), 0.0, 0.0
        for split, pair, known in zip(self.pairs, self.contact.pairs, self.memory, strict=True):
            y = self.contact.multipliers[0, pair.own]
            memory = pair.memory_in(self.state)
            parts += split.parts(y, (left, known[0]), (reached, memory))
            if self.contact.consistent:
                frozen += split.frozen(y, moved)
                turned += split.turned(y, moved, memory, joined=self._joins_closest_points())
        closing, step, normals, weights = parts
        step += float(np.vdot(force, left - before))
        if self.contact.consistent:
            # additions to frozen rows: the derivatives of normals and of weights
            normals, weights = normals + turned, weights + float(np.vdot(force, moved)) - frozen - turned
        self.work += 0.5 * np.array([closing, step, normals, weights])

    def _joins_closest_points(self) -> bool:
        rows = self.contact.factored
        joins = (isinstance(reduced, ConstantColumns) and reduced.rows is rows for reduced in self.contact.reduced)
        return rows is not None and rows.count > 0 and any(joins)

    def _normal_force(self) -> Floats:
        """Return nodal forces (N, 2) [N] of the normal multipliers."""
        rows = self.contact.rows
        if not rows.count or not self.contact.friction:
            return self.state["contact_force"]
        normal = rows.to_csr(len(self.velocity))[: rows.count]
        return np.asarray(normal.T @ self.contact.multipliers[0, rows.slot[: rows.count]]).reshape(-1, 2)


def split_work(
    contact: ContactSystem, integrator: Integrator, state: State, reference: Floats, where: Where
) -> WorkSplit:
    """Return what splits the work of a contact system. Raises SceneError if the scheme is not leapfrog."""
    if not isinstance(integrator, ExplicitIntegrator) or integrator.velocity_lag != LEAPFROG:
        raise SceneError(
            "the work of contact forces is split in explicit leapfrog steps only",
            where=where,
            got=f"true, with {type(integrator).__name__}",
            allowed='false, or an explicit integrator like "central-difference"',
        )
    if any(pair.smooth for pair in contact.pairs):
        raise SceneError(
            "the work of contact forces is split by derivatives of gaps between segments",
            where=where, got="true, with smooth = true of a contact", allowed="false, or smooth = false",
        )  # fmt: skip
    return WorkSplit(contact, state, reference)


class PairSplit:
    """Work of one pair with finished constraints: its gaps before and after, and the rows of the step.

    twins  pairs like it, with constraints at these positions of the last steps; recently used pairs come last
    """

    def __init__(self, pair: ContactPair, reference: Floats) -> None:
        self.pair = pair
        self.twins = [(np.zeros((0, 2)), twin(pair, reference)) for _ in range(3)]

    def parts(self, y: Floats, start: Instant, end: Instant) -> Floats:
        """Return twice the `CONTACT_WORK` (4,) [mJ] by forces y (k,) [N], between positions (N, 2) two steps apart."""
        (before, _), (reached, _), first, last = start, end, self._at(*start), self._at(*end)
        gaps = first.gaps_at(before)[:, 0], last.gaps_at(reached)[:, 0]
        pressed, lone = _known(y, *gaps)
        moved = self.moved(reached - before)
        closing = float(y[pressed] @ (gaps[1] - gaps[0])[pressed])
        return np.array([closing, float(y[pressed] @ moved[pressed]) - closing, 0.0, float(y[lone] @ moved[lone])])

    def moved(self, motion: Floats) -> Floats:
        """Return the change (k,) [mm] of the gaps by a motion (N, 2), by the frozen rows of the step."""
        origin = np.zeros_like(motion)
        return np.asarray((self.pair.gaps_at(motion) - self.pair.gaps_at(origin))[:, 0])

    def frozen(self, y: Floats, motion: Floats) -> float:
        """Return twice the work of forces y (k,) along these rows."""
        pressed = y > 0.0
        return float(y[pressed] @ self.moved(motion)[pressed])

    def turned(self, y: Floats, motion: Floats, memory: Floats, *, joined: bool) -> float:
        """Return twice the work along derivatives of normals; `joined` if they are normal to all separations."""
        return 0.0

    def _at(self, positions: Floats, memory: Floats) -> ContactPair:
        """Return the twin with the constraints at these positions, made on demand."""
        known = next((n for n, (at, _) in enumerate(self.twins) if np.array_equal(at, positions)), None)
        if known is not None:
            self.twins.append(self.twins.pop(known))
            return self.twins[-1][1]
        _, found = self.twins.pop(0)
        # a search of its own for each: constraints do not depend on earlier calls, or calls before a restart
        found.find_near(positions[found.slave.nodes], positions[found.master.nodes])
        found.update(positions, memory.copy())
        self.twins.append((positions.copy(), found))
        return found


class OperatorSplit(PairSplit):
    """Work of one pair whose algorithm gives operators: normals and weights are distinguished.

    rows_at  point of the motion that rows belong to: 0.5, its middle (consistent forces); 1.0, its end
    """

    pair: OperatorPair

    def __init__(self, pair: OperatorPair, reference: Floats, consistent: bool) -> None:
        super().__init__(pair, reference)
        self.gradients = PairGradients(pair)
        self.touched = np.concatenate([pair.slave.nodes, pair.master.nodes])
        self.rows_at = 0.5 if consistent else 1.0

    def parts(self, y: Floats, start: Instant, end: Instant) -> Floats:
        """Return the work as in `PairSplit.parts`."""
        (before, _), (reached, _), first, last = start, end, self._operators(*start), self._operators(*end)
        at, then = self._sides(before), self._sides(reached)
        (r0, g0), (r1, g1) = _separations(first, at), _separations(last, then)
        ahead, back = _separations(last, at)[0], _separations(first, then)[0]
        pressed, lone = _known(y, g0, g1)
        change = self.moved(reached - before)
        n0, n1, late = first.normals, last.normals, self.rows_at
        row = (1.0 - late) * n0 + late * n1
        closing = _dot(n1, r1) - _dot(n0, r0)
        normals = _dot(n1 - n0, late * r0 + (1.0 - late) * r1)
        weights = _dot(row, late * (ahead - r0) + (1.0 - late) * (r1 - back))
        step = change - _dot(row, late * (r1 - ahead) + (1.0 - late) * (back - r0))
        of_pressed = [float(y[pressed] @ part[pressed]) for part in (closing, step, -normals, -weights)]
        # constraints that appeared or vanished did so with their weights
        of_pressed[-1] += float(y[lone] @ change[lone])
        return np.array(of_pressed)

    def moved(self, motion: Floats) -> Floats:
        """Return the change as in `PairSplit.moved`."""
        return _dot(self.pair.normals, _separations(self.pair, self._sides(motion))[0])

    def turned(self, y: Floats, motion: Floats, memory: Floats, *, joined: bool) -> float:
        """Return the work as in `PairSplit.turned`."""
        if joined:
            return 0.0
        found = self.gradients.found(memory)
        of = slice(0, found.normal_count)
        k, moved = found.normal_of[of], motion[self.touched].reshape(-1)[found.normal_moved[of]]
        along = _dot(self.pair.separation[k], found.dnormal[of])
        return float((np.maximum(y, 0.0)[k] * along * moved).sum())

    def _operators(self, positions: Floats, memory: Floats) -> OperatorPair:
        found = self._at(positions, memory)
        assert isinstance(found, OperatorPair)
        return found

    def _sides(self, positions: Floats) -> SurfacePositions:
        return SurfacePositions(positions[self.pair.slave.nodes], positions[self.pair.master.nodes])


def _separations(pair: OperatorPair, at: SurfacePositions) -> tuple[Floats, Floats]:
    """Return separations (k, 2) [mm] of surfaces at these positions by the pair's weights, and gaps (k,)."""
    separation, gaps = np.zeros((pair.slots, 2)), np.full((pair.slots, 2), FAR)
    pair.separations(at, pair.normals, separation, gaps)
    return separation, gaps[:, 0]


def _known(y: Floats, *gaps: Floats) -> tuple[Flags, Flags]:
    """Return constraints with a force that exist at both ends of a motion, and constraints with a force that do not."""
    there = np.all([gap < FAR for gap in gaps], axis=0)
    return (y > 0.0) & there, (y > 0.0) & ~there


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ki,ki->k", a, b))


def twin(pair: ContactPair, reference: Floats) -> ContactPair:
    """Return a pair of the same constraints that shares no array with it, without friction, with gaps in full."""
    fixed = (pair.coupling.fixed,) if isinstance(pair, OperatorPair) else ()
    kind: Any = type(pair)
    made: ContactPair = kind(pair.name, pair.method, pair.slave, pair.master, reference, pair.first_slot, None, *fixed)
    return made
