"""All contact pairs of a model for implicit integrators: trial conditions and their derivatives."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from scipy.sparse import csr_array, vstack

from contactlab.api import Conditions, ContactDerivatives, Floats, ImplicitEnforcement, Ints, State
from contactlab.contact.contact_pairs import linearised
from contactlab.contact.coupling import Coupling
from contactlab.contact.examination import examine_pair
from contactlab.contact.explicit_system import allocate_rows
from contactlab.contact.held_together import held_together
from contactlab.contact.linearisation import PairDerivatives, PairLinearisation
from contactlab.contact.pair import ContactPair, shown
from contactlab.contact.passage import first_passage
from contactlab.contact.sliding import varying
from contactlab.contact.step_rows import StepRows

if TYPE_CHECKING:
    from contactlab.contact.potential_pair import PotentialPair
    from contactlab.contact.pressure_store import PressureStore


class ImplicitContactSystem:
    """All contact pairs and their enforcement. Implements `contactlab.api.ImplicitContact`.

    passes        all pairs; `pairs` are those that reports show (see `ContactPair.second`)
    follows_gaps  whether normal forces act along the derivatives of the gaps
    potentials    pairs whose forces come from an energy; `ruled` are the others, which set conditions
    consistent    whether they do so in steps of a motion, which holds gaps by rows that are those of the whole step
    pace          how far multipliers that were merged at the start of a step come free in it: 1, at once, or less in
                  load steps that had to be cut (forces jump where one comes free: no shorter step would help otherwise)
    freedom       (k,) how free the model's multipliers were in the last accepted step, from 0 (merged) to 1
    """

    def __init__(
        self,
        pairs: tuple[ContactPair, ...],
        enforcement: ImplicitEnforcement,
        state: State,
        time: Floats,
        follows_gaps: bool,
    ) -> None:
        """`time` (1,) [s] is filled with that at which conditions hold: pairs that follow it look there."""
        self.pairs, self.passes = shown(pairs), pairs
        self.enforcement, self.state, self.time = enforcement, state, time
        self.friction = any(pair.friction is not None for pair in pairs)
        nodes = len(state["displacement"])
        self.potentials = cast("tuple[PotentialPair, ...]", tuple(pair for pair in pairs if pair.by_energy))
        for pair in self.potentials:
            if pair.friction is not None:
                pair.kept = state[f"friction.{pair.name}"]
        self.ruled = tuple(pair for pair in pairs if not pair.by_energy)
        self.linear = tuple(linearised(pair, nodes) for pair in self.ruled)
        # statics have no start of a step that anything would have to hold to
        self.follows_gaps, self.consistent = follows_gaps, follows_gaps and "velocity" in state
        self.stepped = tuple(StepRows(linear) for linear in self.linear) if self.consistent else ()
        self.conditions = _conditions(pairs, state["multipliers"], self.friction)
        self.pace = 1.0
        self.freedom = np.ones(state["multipliers"].shape[1])
        self.memories = [np.zeros_like(self._memory(pair)) for pair in self.ruled]
        self.start = np.zeros((nodes, 2))
        self.flexibility = np.ones((nodes, 2))
        self.multipliers = state["multipliers"]
        self.rows = allocate_rows(self.multipliers.shape[1], 32, self.friction)
        self.factored = None  # conditions that are never written as `FactoredRows`
        self.seconds = 0.0
        self.store: PressureStore | None = None  # of a normal law
        self.varying = varying(pairs, state)

    @property
    def stored_since_start(self) -> float:
        """Energy [mJ] that surfaces hold beyond that of the start; none without a normal law or a potential."""
        held = self.store.since_start() if self.store is not None else 0.0
        return held + sum(pair.stored_since_start() for pair in self.potentials)

    def calls_per_step(self) -> Counter[str]:
        """How often an iteration calls the algorithms, by what they are asked for."""
        return sum((Counter(pair.calls_per_step()) for pair in self.passes), Counter())

    def _memory(self, pair: ContactPair) -> Floats:
        name = f"memory.{pair.name}"
        return self.state[name] if name in self.state else np.zeros((0, len(pair.slave.nodes)))

    def begin_step(self, position: Floats, time: float) -> None:
        """A step that ends at `time` [s] starts at `position` (N, 2), with what the state remembers."""
        self.start[:] = position
        self.time[0] = time
        for pair, memory in zip(self.ruled, self.memories, strict=True):
            memory[:] = self._memory(pair)
            pair.evaluated = False
        for pair in self.potentials:
            pair.begin_step(position)
            # what the last step wrote for reports is no force of a condition
            self.conditions.force[:, pair.own] = 0.0
        for pair, sliding in self.varying:
            sliding.begin_step(pair, time, time - self.state.time)
        self._release(time)
        for rows, memory in zip(self.stepped, self.memories, strict=False):
            half = 0.5 * (time - self.state.time)
            rows.begin(self.state.time, position, position + half * self.state["velocity"], memory)
        self.conditions.anchor[:] = self.conditions.force

    def _release(self, time: float) -> None:
        """Free multipliers, at once or by and by: what one comes free by changes gaps and forces at once."""
        if self.pace >= 1.0:
            for coupling, _ in self._couplings():
                coupling.let_go()
            return
        for coupling, freedom in self._couplings():
            coupling.untie(freedom)
        self.time[0] = self.state.time
        self.evaluate(self.start)
        self.time[0] = time
        for coupling, freedom in self._couplings():
            coupling.hold(self._freed(coupling, freedom))

    def _couplings(self) -> Iterator[tuple[Coupling, Floats]]:
        """Those of the pairs that have one, and how free their multipliers were in the last accepted step."""
        for linear in self.linear:
            if isinstance(linear, PairLinearisation):
                yield linear.pair.coupling, self.freedom[linear.pair.own]

    def _freed(self, coupling: Coupling, freedom: Floats) -> Floats:
        """How free multipliers are after a step that frees them at `pace`: (k,), 0 where they are merged."""
        return np.where(coupling.free, np.minimum(freedom + self.pace, 1.0), 0.0)

    def accept(self) -> None:
        """What the last evaluation remembers becomes part of the state."""
        for pair, memory in zip(self.ruled, self.memories, strict=True):
            self._memory(pair)[:] = memory
            pair.evaluated = True
        for pair in self.potentials:
            pair.accept(self.multipliers)
        for pair, sliding in self.varying:
            sliding.accept(pair, self.conditions.slip[pair.own], self.conditions.force[0, pair.own])
        for coupling, freedom in self._couplings():
            freedom[:] = self._freed(coupling, freedom)
        for stepped in self.stepped:
            stepped.linear.pair.compute_gaps(stepped.start + stepped.moved)
        self._write_rows()
        if self.stepped and self.friction:
            rows = self.rows
            rows.slip[: rows.count] = self.conditions.slip[rows.slot[: rows.count]]

    def _write_rows(self) -> None:
        """Rows of the conditions that bear forces, as the scalars of every step want them."""
        while True:
            self.rows.count = entries = 0
            for pair in self.pairs:
                entries = pair.append_rows(self.rows, entries, -np.inf, self.multipliers, self.start)
                if entries < 0:
                    break
            if entries >= 0:
                return
            self.rows = allocate_rows(
                self.multipliers.shape[1], 2 * len(self.rows.node) // len(self.rows.gap) + 1, self.friction
            )

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions`; see `contactlab.api.ImplicitContact`."""
        began, c = perf_counter(), self.conditions
        c.present[:] = False
        for number, (linear, memory) in enumerate(zip(self.linear, self.memories, strict=True)):
            pair, stepped = linear.pair, self.stepped[number] if self.stepped else None
            if stepped is None:
                linear.evaluate(position, self.start, memory)
            else:
                stepped.move(position)
            examine_pair(pair)
            own = pair.own
            flexibility = linear.flexibilities(self.flexibility)
            # without flexibility both sides are held: there is nothing that a force could do
            c.present[own] = flexibility > 0.0
            if stepped is not None:
                c.present[own] &= stepped.present
            c.stiffness[own] = np.divide(1.0, flexibility, out=np.full(pair.slots, np.inf), where=flexibility > 0.0)
            c.gap[own] = pair.gaps[:, 0] if stepped is None else stepped.gaps()
            c.measure[own], c.size[own] = pair.cover, pair.full
            if self.friction:
                slip = linear.slip if stepped is None else stepped.slips()
                c.slip[own] = slip if len(slip) else 0.0
            if pair.sliding is not None:
                self._write_bounds(pair)
        for pair in self.potentials:
            pair.evaluate(position)
        c.force[:, ~c.present] = 0.0
        self.seconds += perf_counter() - began

    def _write_bounds(self, pair: ContactPair) -> None:
        assert pair.sliding is not None
        bound = self.conditions.bound[:, pair.own]
        bound[:] = pair.sliding.of(_ALL)
        bound[:, held_together(pair, self.flexibility, self.start)] = 0.0

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Nodal forces of the trial multipliers; see `contactlab.api.ImplicitContact`."""
        normal[:] = 0.0
        tangential[:] = 0.0
        for pair in self.potentials:
            pair.add_forces(normal, tangential)
        for stepped in self.stepped:
            stepped.add_forces(self.conditions.force[:, stepped.linear.pair.own], normal, tangential)
        if self.stepped:
            return
        for linear, memory in zip(self.linear, self.memories, strict=True):
            if self.follows_gaps and isinstance(linear, PairLinearisation):
                self._add_consistent(linear, memory, normal, tangential)
            else:
                linear.add_forces(self.conditions.force, normal, tangential)

    def _add_consistent(self, linear: PairLinearisation, memory: Floats, normal: Floats, tangential: Floats) -> None:
        """Normal forces along the derivatives of the gaps; those of friction by weights."""
        force = self.conditions.force.copy()
        own = force[0, linear.pair.own]
        chosen = np.flatnonzero(own).astype(np.int32)
        if len(chosen):
            pushed = linear.gap_derivatives(chosen, memory).T @ own[chosen]
            normal += pushed.reshape(-1, 2)
        own[:] = 0.0
        linear.add_forces(force, normal, tangential)

    @property
    def by_energy(self) -> bool:
        """Whether some forces come from potentials; see `contactlab.api.ImplicitContact`."""
        return bool(self.potentials)

    @property
    def acts(self) -> bool:
        """Whether there are nodal forces without any choice of conditions; see `contactlab.api.ImplicitContact`."""
        return self.by_energy or bool(self.conditions.force.any())

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """How much of a motion no surface passes through; see `contactlab.api.ImplicitContact`."""
        passage = first_passage(self.ruled, position, position + motion, depth)
        allowed = (pair.free_share(position, motion) for pair in self.potentials)
        return min(1.0 if passage is None else passage.share, *allowed, 1.0)

    def settled(self) -> bool:
        """Whether friction belongs to the end of the step; see `contactlab.api.ImplicitContact`."""
        taken = sum(pair.take_over() for pair in self.potentials)
        return self._bounds_follow() and taken == 0

    def _bounds_follow(self) -> bool:
        """Whether bounds that vary belong to the slips of this step; if not, they do from now on."""
        c, follow = self.conditions, True
        for pair, sliding in self.varying:
            slip, force = c.slip[pair.own], c.force[:, pair.own]
            give = sliding.measured_give(slip, force[1], 1.0 / c.stiffness[pair.own])
            if sliding.follow(pair, slip, give, force) > SETTLED:
                self._write_bounds(pair)
                follow = False
        return follow

    def dissipation(self) -> float:
        """Energy [mJ] that friction takes in the step; see `contactlab.api.ImplicitContact`."""
        c = self.conditions
        # what is not there may have no slip
        sliding = -float(c.force[1] @ np.where(c.present, c.slip, 0.0)) if self.friction else 0.0
        return sliding + sum(pair.dissipation() for pair in self.potentials)

    def scale(self, flexibility: Floats) -> None:
        """Nodal flexibilities from which contact stiffnesses follow."""
        self.flexibility[:] = flexibility

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Derivatives of the chosen slots; see `contactlab.api.ImplicitContact`."""
        began, force = perf_counter(), self.conditions.force
        parts: list[PairDerivatives] = []
        for number, (linear, memory) in enumerate(zip(self.linear, self.memories, strict=True)):
            pair = linear.pair
            own = pair.own
            slots = chosen[(chosen >= own.start) & (chosen < own.stop)] - pair.first_slot
            if self.stepped:
                parts.append(self.stepped[number].linearise(slots, force[:, own]))
                continue
            y_t = force[1, own] if pair.friction is not None else None
            found = linear.linearise(slots.astype(np.int32), force[0, own], y_t, memory)
            consistent = self.follows_gaps and isinstance(linear, PairLinearisation)
            # how directions change is taken from rows by weights: their own change needs second derivatives
            parts.append(replace(found, normal=found.gap) if consistent else found)
        derivatives = self._joined(parts) if parts else self._unconditional(len(chosen))
        for potential in self.potentials:
            force_derivative = derivatives.force + potential.force_derivative(2 * len(self.start))
            derivatives = derivatives._replace(force=force_derivative)
        self.seconds += perf_counter() - began
        return derivatives

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Directions of impulses; see `contactlab.api.ImplicitContact`."""
        if not self.stepped:
            found = self.linearise(chosen)
            return found.normal, found.tangent
        normal, tangent = [], []
        for stepped in self.stepped:
            own = stepped.linear.pair.own
            slots = chosen[(chosen >= own.start) & (chosen < own.stop)] - own.start
            along, across = stepped.directions(slots)
            normal.append(along)
            tangent.append(along * 0.0 if across is None else across)
        return _stacked(normal), _stacked(tangent) if self.friction else None

    def _unconditional(self, rows: int) -> ContactDerivatives:
        """Those of a model without conditions."""
        size = 2 * len(self.start)
        none = csr_array((rows, size))
        tangent = none if self.friction else None
        return ContactDerivatives(none, tangent, none, tangent, csr_array((size, size)))

    def _joined(self, parts: list[PairDerivatives]) -> ContactDerivatives:
        if len(parts) == 1:
            p = parts[0]
            return ContactDerivatives(p.normal, p.tangent, p.gap, p.slip, p.force)
        tangent = [p.normal * 0.0 if p.tangent is None else p.tangent for p in parts] if self.friction else None
        slip = [p.gap * 0.0 if p.slip is None else p.slip for p in parts] if self.friction else None
        total = parts[0].force
        for part in parts[1:]:
            total = total + part.force
        return ContactDerivatives(
            _stacked([p.normal for p in parts]),
            _stacked(tangent),
            _stacked([p.gap for p in parts]),
            _stacked(slip),
            total,
        )


_ALL = slice(None)
SETTLED = 1e-5  # of the largest bound: what bounds that follow slips may still change by


def _stacked(parts: list[Any] | None) -> Any:
    return None if parts is None else vstack(parts, format="csr")


def _conditions(pairs: tuple[ContactPair, ...], multipliers: Floats, friction: bool) -> Conditions:
    k = multipliers.shape[1]
    bound = np.zeros((3, k if friction else 0))
    for pair in pairs:
        if pair.sliding is not None:
            bound[:, pair.own] = pair.sliding.of(_ALL)
    return Conditions(
        present=np.zeros(k, np.bool_),
        gap=np.zeros(k),
        slip=np.zeros(k if friction else 0),
        force=multipliers,
        anchor=np.zeros_like(multipliers),
        measure=np.zeros(k),
        size=np.zeros(k),
        bound=bound,
        stiffness=np.zeros(k),
    )
