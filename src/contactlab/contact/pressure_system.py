"""All contact pairs of a model under a normal law, in explicit steps: forces of the gaps at the start of a step."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np

from contactlab.api import ExplicitEnforcement, Floats, Ints, NormalLaw, Rows, Solve, State
from contactlab.contact.consistent_system import ConsistentContactSystem
from contactlab.contact.explicit_system import slips
from contactlab.contact.pair import ContactPair
from contactlab.contact.pressure_memory import named
from contactlab.contact.pressure_response import PressureStore
from contactlab.kernels.contact.pair import FAR
from contactlab.kernels.contact.rub import push, rub, start_slips

AHEAD = 2.0  # steps for which the slope is bounded
SPARE = 1.3  # margin on the slope of the step length: within it no step has to be shortened
CLOSING = 2.0  # margin of springs that close and open again: near the stable step each time gives or takes energy
TOLERANCE, SWEEPS = 1e-10, 200  # of friction: segment lengths, and most Gauss-Seidel iterations


class PressureForces(ExplicitEnforcement):
    """Placeholder for an explicit enforcement if a normal law gives the forces."""

    exact = False

    def __init__(self, law: NormalLaw) -> None:
        self.law = law

    def solve(self, rows: Rows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve:
        """Raise NotImplementedError: forces follow from the gaps at the start of a step, which rows lack here."""
        raise NotImplementedError("forces of a normal law are found by the contact system")


class PressureContactSystem(ConsistentContactSystem):
    """Forces are length times pressure of the gaps at the start of the step, along the derivatives of the gaps.

    So leapfrog keeps the energy of bodies and surfaces, within its stable step; friction is found under these forces
    with the motion of the step.

    store      the energy of the surfaces, with the law and the stiffness of the cells behind each slot
    densities  (pairs, 3) of each pair, largest length over mass of a node of the slave and of the master [mm/t], and
               of the master over the length of its segments [1/t]
    allowed    (pairs,) [MPa/mm] steepest slope allowed by the step length; in the state, as steps follow it
    longest    (pairs,) [mm] longest slave segments counted on a node of the master; in the state, too
    rows_each  (pairs,) most constraints of a node, such as two in a corner of the master; in the state, too
    shear      (pairs,) [MPa/mm] shear per slip of pairs with friction by springs
    shared     True if a node belongs to several pairs, whose slopes then add up
    """

    def __init__(self, pairs: tuple[ContactPair, ...], store: PressureStore, state: State, densities: Floats) -> None:
        super().__init__(pairs, PressureForces(store.law), state)
        self.store, self.law, self.stiffness, self.densities = store, store.law, store.stiffness, densities
        self.memory = store.memory
        self.shared = len(np.unique(nodes := np.concatenate([nodes_of(pair) for pair in pairs]))) < len(nodes)
        self.allowed, self.longest, self.rows_each = state["contact_slope"]
        self.pressure, self.slope = np.zeros_like(self.stiffness), np.zeros_like(self.stiffness)
        self.shear = np.zeros(len(pairs))

    def _solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        self._assemble(self.law.begins(), current, predicted)
        rows, asked = self.rows, perf_counter()
        count, slot, tangential = rows.count, rows.slot[: rows.count], len(rows.slip) > 0
        pressure, slope = self.pressure[:count], self.slope[:count]
        beside = named(self.memory, slot)
        self.law.pressure(rows.gap[:count], self.stiffness[slot], rows.size[:count], pressure, slope, **beside)
        rubbed = self.multipliers[1, slot] if tangential else None
        self.multipliers[:] = force[:] = 0.0
        self.multipliers[0, slot] = rows.measure[:count] * pressure
        if rubbed is not None:
            self.multipliers[1, slot] = rubbed
        sweeps, residual = self._push(predicted, current, compliance, force)
        done = Solve(sweeps, residual, 0, float(np.abs(compliance * force).max(initial=0.0)))
        if self.varying and count:
            done = self._follow(done, lambda: self._rub_again(done, compliance, force), compliance, force)
        self.solution_s += perf_counter() - asked
        return done

    def _push(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> tuple[int, float]:
        """Add nodal forces of all rows, with friction under them. Return sweeps, and the last change."""
        count, rows, sweeps, residual = self.rows.count, self.rows, 1, 0.0
        push(count, rows, self.multipliers, force)
        if len(rows.slip):
            start_slips(count, rows, current, predicted)
            sweeps, residual = rub(count, rows, compliance, self.multipliers, force, TOLERANCE, SWEEPS)
        return sweeps, residual

    def _rub_again(self, done: Solve, compliance: Floats, force: Floats) -> Solve:
        sweeps, residual = rub(self.rows.count, self.rows, compliance, self.multipliers, force, TOLERANCE, SWEEPS)
        return done._replace(sweeps=done.sweeps + sweeps, residual=residual)

    def _advance(self, pair: ContactPair, first: int, current: Floats, predicted: Floats) -> None:
        """Leave gaps at the start of the step."""

    @property
    def stored_since_start(self) -> float:
        """Return the energy [mJ] stored in the surfaces since the start, at the time of the velocities.

        Gaps and forces belong to the start of the last step; velocities belong to its middle.
        """
        half = 0.5 * self.state.last_dt * float(np.vdot(self.velocity, self.state["contact_force"]))
        return self.store.since_start() - half

    def rate(self, step: float) -> float:
        """Return the largest eigenvalue [1/s2] of the law: largest slope in the next steps, times lengths over masses.

        A motion of the nodes (u, v) of both sides changes gaps by u - Pv, with weights P that add up to one; so the
        energy of slopes s is at most s times length over mass of each side, summed, times the energy of the masses.
        On a node of the master this is its own length, or that of a longer slave node which presses on it alone.
        """
        moved = 2.0 * AHEAD * step * float(np.abs(self.velocity).max(initial=0.0))
        if self.memory is not None and self.memory.dt == 0.0:
            self.memory.begin_step(self.state.time, step)
        for number, pair in enumerate(self.passes):
            own = pair.own
            gaps = np.minimum(np.where(pair.gaps[:, 0] < FAR, pair.gaps[:, 0], 0.0), self.law.begins())
            size = np.where(pair.full > 0.0, pair.full, pair.size)
            steepest = float(self.shear[number])
            # laws with memory may be steeper on unloading
            for way in (-moved,) if self.memory is None else (-moved, 0.0, moved):
                pressure, slope = np.zeros_like(gaps), np.zeros_like(gaps)
                where = np.minimum(gaps + way, -1e-9 * pair.size)
                self.law.pressure(where, self.stiffness[own], size, pressure, slope, **named(self.memory, own))
                steepest = max(steepest, float(-slope.min(initial=0.0)))
            self.allowed[number] = SPARE * steepest
            near = pair.gaps[:, 0] < FAR
            self.longest[number] = 0.0 if pair.half else size[near if near.any() else slice(None)].max()
            self.rows_each[number] = max(1, _most(np.flatnonzero(near).astype(np.int32), pair))
        slave, master, per_length = self.densities.T
        squares = CLOSING * self.allowed * self.rows_each * (slave + np.maximum(master, self.longest * per_length))
        return float(squares.sum() if self.shared else squares.max())

    @property
    def begin(self) -> tuple[Callable[[float, float], None], ...]:
        """Inform a law with memory first."""
        return super().begin if self.memory is None else (self._begin_step, *super().begin)

    @property
    def follow(self) -> tuple[Callable[[float, float], None], ...]:
        """Inform a law with memory."""
        return super().follow if self.memory is None else (self._remember, *super().follow)

    def _begin_step(self, end: float, dt: float) -> None:
        assert self.memory is not None
        self.memory.begin_step(self.state.time, dt)

    def _remember(self, end: float, dt: float) -> None:
        """Move the gaps at the start of the step, and its slips, into memory."""
        assert self.memory is not None
        rows, slot, slots = self.rows, self.rows.slot[: self.rows.count], len(self.stiffness)
        gap, size = np.full(slots, self.law.begins()), np.zeros(slots)
        gap[slot], size[slot] = rows.gap[: rows.count], rows.size[: rows.count]
        slip = slips(rows, slots, self.compliance, self.state["contact_force"])[0] if self.friction else None
        self.memory.accept(gap, self.stiffness, size, slip)

    @property
    def stiffened(self) -> bool:
        """True if slopes, lengths or constraints of a node of the last step are above what `rate` allowed."""
        count = self.rows.count
        slot, slope, measure = self.rows.slot[:count], self.slope[:count], self.rows.measure[:count]
        for number, pair in enumerate(self.passes):
            own = (slot >= pair.first_slot) & (slot < pair.first_slot + pair.slots) & (slope < 0.0)
            allowed, longest = self.allowed[number], self.longest[number]
            if (
                -slope[own].min(initial=0.0) > allowed
                or _most(slot[own] - pair.first_slot, pair) > self.rows_each[number]
            ):
                return True
            if longest > 0.0 and -(slope * measure)[own].min(initial=0.0) > allowed * longest:
                return True
        return False


def _most(slots: Ints, pair: ContactPair) -> int:
    """Return the largest number of these constraints on a node."""
    if pair.rows_per_node == 1:
        return min(1, len(slots))
    return int(np.bincount(slots % (pair.slots // pair.rows_per_node)).max(initial=0))


def nodes_of(pair: ContactPair) -> Ints:
    """Return nodes of both sides."""
    return np.concatenate([pair.slave.nodes, pair.master.nodes])
