"""All contact pairs of a model for implicit integrators: trial constraints and their derivatives."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from functools import reduce
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
from scipy.sparse import csr_array

from contactlab.api import Conditions, ContactDerivatives, Floats, FrictionBound, ImplicitEnforcement, Ints, Rows, State
from contactlab.api.compiled.friction import STICKS
from contactlab.contact.examined import examine_pair
from contactlab.contact.friction import held_together, taking_tractions, varying
from contactlab.contact.linearisation import linearised
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, shown
from contactlab.contact.passage import first_passage
from contactlab.implicit.sparse import stacked, total
from contactlab.kernels.contact.coupling import Coupling

SETTLED = 1e-5  # of the largest bound: tolerance of bounds that follow slips

StepCall = Callable[[float, float], None]


class ImplicitContactSystem:
    """All contact pairs and their enforcement. Implements `contactlab.api.ImplicitContact`.

    passes        all pairs, an `OperatorPair` for each mortar; `pairs` are in reports (see `ContactPair.second`)
    consistent    True if normal forces act along the derivatives of the gaps
    whole_steps   True if they do so in dynamic steps, which hold gaps by rows that belong to the whole step
    linear        pairs that set constraints: all whose forces do not come from an energy
    multipliers   (r, k) [N] of the state, changed in place: the same array as `conditions.force` and
                  `Trial.multipliers`. `evaluate` clears slots without a constraint, `LineSearch` adds corrections;
                  rarely, starts of an iteration, friction without a bound yet, and impulses at the end of a step
                  write to it
    release       (k,) how far multipliers came free in the last accepted step, from 0 (merged) to 1; in the state
    pace          (2,) in the state: what a step adds to it, 1, or less in load steps that had to be cut (forces jump on
                  release: a shorter step alone would not help), and what the last accepted step added. What came free
                  in part is merged later than what comes free, also in the step that frees all
    tenth         [s] a tenth of the loading or the time, by which potentials see how long a step is; inf if unknown
    """

    def __init__(
        self,
        pairs: tuple[ContactPair, ...],
        enforcement: ImplicitEnforcement,
        state: State,
        time: Floats,
        consistent: bool,
    ) -> None:
        """Fill `time` (1,) [s] with the time at which constraints hold; pairs that depend on time read it."""
        self.pairs, self.passes = shown(pairs), pairs
        self.enforcement, self.state, self.time = enforcement, state, time
        self.friction = any(pair.friction is not None for pair in pairs)
        nodes = len(state["displacement"])
        # in statics nothing has to match the start of a step
        self.consistent, self.whole_steps = consistent, consistent and "velocity" in state
        self.linear = tuple(
            linearised(pair, nodes, consistent, self.whole_steps) for pair in pairs if not pair.by_energy
        )
        self.multipliers = state["multipliers"]
        self.conditions = _conditions(pairs, self.multipliers, self.friction)
        self.started = np.zeros_like(self.multipliers)
        self.tenth = np.inf
        fields = state.fields  # of statics alone
        self.release = fields.get("release", np.empty(self.multipliers.shape[1]))
        self.pace = fields.get("release_pace", np.empty(2))
        self.release[:] = self.pace[:] = 1.0
        self.start = np.zeros((nodes, 2))
        self.flexibility = np.ones((nodes, 2))
        self.rows = Rows.allocate(self.multipliers.shape[1], 32, self.friction)
        self.factored = None  # constraints are never written as `FactoredRows`
        self.seconds = 0.0
        self.varying = varying(pairs, state)

    @property
    def stored_since_start(self) -> float:
        """Energy [mJ] stored in surfaces beyond their energy at the start; zero without normal law and potential."""
        return 0.0

    def calls_per_step(self) -> Counter[str]:
        """Return how many calls of each method of the algorithms an iteration makes."""
        return sum((Counter(pair.calls_per_step()) for pair in self.passes), Counter())

    begin: tuple[StepCall, ...] = ()
    """Nothing is called before a step: `begin_step` is a call of the integrator."""

    @property
    def follow(self) -> tuple[StepCall, ...]:
        """Functions called with the end and the length [s] of each step after it: bounds that follow stresses."""
        return taking_tractions(self.varying)

    def begin_step(self, position: Floats, time: float) -> None:
        """Begin a step that ends at `time` [s] from `position` (N, 2), with the memory of the state."""
        self.start[:] = position
        self.time[0] = time
        for linear in self.linear:
            linear.memory[:] = linear.pair.memory_in(self.state)
        for _, sliding in self.varying:
            sliding.begin_step(time, time - self.state.time)
        self._release(time)
        middle = position
        if self.whole_steps:
            middle = position + 0.5 * (time - self.state.time) * self.state["velocity"]
        for linear in self.linear:
            linear.begin(self.state.time, position, middle)
        self.conditions.anchor[:] = self.multipliers
        self.started[:] = self.multipliers

    def _release(self, time: float) -> None:
        """Free multipliers, in full or in part: a release changes gaps and forces immediately."""
        for coupling, release in self._couplings():
            if (self.pace < 1.0).any():
                coupling.untie(release)
            else:
                coupling.let_go()
        if self.pace[0] >= 1.0:
            return
        self._evaluate_start(time)
        for coupling, release in self._couplings():
            coupling.hold(self._freed(coupling, release))

    def _evaluate_start(self, time: float) -> None:
        """Fill `conditions` at the start of a step that ends at `time` [s]."""
        self.time[0] = self.state.time
        self.evaluate(self.start)
        self.time[0] = time

    def _couplings(self) -> Iterator[tuple[Coupling, Floats]]:
        """Yield the couplings of the pairs, and the release of their multipliers in the last accepted step."""
        for pair in self.passes:
            if isinstance(pair, OperatorPair):
                yield pair.coupling, self.release[pair.own]

    def _freed(self, coupling: Coupling, release: Floats) -> Floats:
        """Return the release (k,) of multipliers after a step that frees them at `pace`, 0 if they are merged."""
        return np.where(coupling.free, np.minimum(release + self.pace[0], 1.0), 0.0)

    def accept(self) -> None:
        """Move the memory of the last evaluation into the state."""
        for linear in self.linear:
            linear.pair.memory_in(self.state)[:] = linear.memory
            linear.accept()
        for pair, sliding in self.varying:
            sliding.accept(pair.cover, self.conditions.slip[pair.own], self.multipliers[0, pair.own], pair.idle)
        for coupling, release in self._couplings():
            release[:] = self._freed(coupling, release)
        self.pace[1] = self.pace[0]
        self._write_rows()

    def _write_rows(self) -> None:
        """Write rows of the constraints that bear forces, as the scalars of every step need them."""
        while True:
            self.rows.count = entries = 0
            for pair in self.pairs:
                entries = pair.append_rows(self.rows, entries, -np.inf, self.multipliers, self.start)
                if entries < 0:
                    break
            if entries >= 0:
                break
            self.rows = Rows.allocate(
                self.multipliers.shape[1], 2 * len(self.rows.node) // len(self.rows.gap) + 1, self.friction
            )
        if self.friction:
            self.rows.slip[: self.rows.count] = self.conditions.slip[self.rows.slot[: self.rows.count]]

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions`; see `contactlab.api.ImplicitContact`."""
        began, c = perf_counter(), self.conditions
        c.present[:] = False
        for linear in self.linear:
            pair, own = linear.pair, linear.pair.own
            linear.evaluate(position, self.start)
            examine_pair(pair)
            flexibility = linear.flexibilities(self.flexibility)
            # without flexibility both sides are held: no force can change anything
            c.present[own] = linear.present & (flexibility > 0.0)
            c.stiffness[own] = np.divide(1.0, flexibility, out=np.full(pair.slots, np.inf), where=flexibility > 0.0)
            c.gap[own], c.measure[own], c.size[own] = linear.gap, pair.cover, pair.full
            if self.friction:
                c.slip[own] = linear.slip if pair.friction is not None else 0.0
            if pair.sliding is not None:
                self._write_bounds(pair)
        self.multipliers[:, ~c.present] = 0.0
        self.seconds += perf_counter() - began

    def _write_bounds(self, pair: ContactPair) -> None:
        assert pair.sliding is not None
        bound = self.conditions.bound[:, pair.own]
        bound[:] = pair.sliding.of(slice(None))
        bound[:, held_together(pair, self.flexibility, self.start)] = 0.0

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Compute nodal forces of the trial multipliers; see `contactlab.api.ImplicitContact`."""
        normal[:] = 0.0
        tangential[:] = 0.0
        self._add_forces(normal, tangential)

    def _add_forces(self, normal: Floats, tangential: Floats) -> None:
        for linear in self.linear:
            linear.add_forces(self.multipliers, normal, tangential)

    by_energy: ClassVar[bool] = False
    """True if some forces come from potentials; see `contactlab.api.ImplicitContact`."""

    @property
    def acts(self) -> bool:
        """True if nodal forces exist without any choice of constraints; see `contactlab.api.ImplicitContact`."""
        return self.by_energy or bool(self.multipliers.any())

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """Return the share of a motion without passage of surfaces; see `contactlab.api.ImplicitContact`."""
        passage = first_passage((linear.pair for linear in self.linear), position, position + motion, depth)
        return min(1.0 if passage is None else passage.share, 1.0)

    def settled(self) -> bool:
        """True if friction belongs to the end of the step; see `contactlab.api.ImplicitContact`."""
        # bounds that vary fit the slips of this step, or are updated
        c, follow = self.conditions, True
        for pair, sliding in self.varying:
            slip, force = c.slip[pair.own], self.multipliers[:, pair.own]
            give = sliding.measured_give(slip, force[1], 1.0 / c.stiffness[pair.own])
            if sliding.follow(pair.cover, slip, give, force) > SETTLED:
                self._write_bounds(pair)
                follow = False
        return follow

    def dissipation(self) -> float:
        """Return the energy [mJ] dissipated by friction in the step; see `contactlab.api.ImplicitContact`."""
        return self._rubbed(self.multipliers[-1])

    def _rubbed(self, shear: Floats) -> float:
        """Return the energy [mJ] that tangential forces (k,) [N] dissipate over the slips; two passes count half."""
        if not self.friction:
            return 0.0
        work = np.where(self.conditions.present, shear * self.conditions.slip, 0.0)
        return 0.0 - sum(pair.share * float(work[pair.own].sum()) for pair in self.passes)

    def friction_along_the_way(self) -> tuple[float, float]:
        """Return friction energy [mJ] of a load step, and its excess over the work of the mean of both ends' forces.

        Surfaces that begin to slide or reverse within the step slide at the bound from there on: at the lower bound of
        both ends, or at the initial force if it lies between the bounds.
        """
        if not self.friction:
            return 0.0, 0.0
        c, y, (normal, shear) = self.conditions, self.multipliers, self.started
        bound, measure = FrictionBound(*c.bound), np.where(c.present, c.measure, 0.0)
        bounds = np.stack([bound.limits(force, measure)[0] for force in (normal, y[0])])
        # only springs slip below the bound; forces of slip stresses miss it by what the last iteration changes
        slides = (np.abs(y[1]) >= bounds[1] * STICKS) | self.enforcement.exact
        way = -np.sign(c.slip)
        start = np.where(slides, way * np.clip(way * shear, bounds.min(axis=0), bounds.max(axis=0)), shear)
        taken = self._rubbed(0.5 * (start + y[1]))
        return taken, taken - self._rubbed(0.5 * (shear + y[1]))

    def scale(self, flexibility: Floats) -> None:
        """Set nodal flexibilities, which determine contact stiffnesses."""
        self.flexibility[:] = flexibility

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Return derivatives of the chosen slots; see `contactlab.api.ImplicitContact`."""
        began, y, size = perf_counter(), self.multipliers, 2 * len(self.start)
        parts = []
        for linear in self.linear:
            own = linear.pair.own
            within = _within(own, chosen)
            if not linear.pair.idle and (len(within) or y[:, own].any()):
                parts.append(linear.linearise(within, y[:, own]))
        if not parts:
            none = csr_array((0, size))
            parts = [ContactDerivatives(none, None, none, None, csr_array((size, size)))]
        change = reduce(total, [part.force for part in parts])
        normal, gap = stacked([p.normal for p in parts]), stacked([p.gap for p in parts])
        tangent = slip = None
        if self.friction:
            tangent = stacked([p.normal * 0.0 if p.tangent is None else p.tangent for p in parts])
            slip = stacked([p.gap * 0.0 if p.slip is None else p.slip for p in parts])
        self.seconds += perf_counter() - began
        return ContactDerivatives(normal, tangent, gap, slip, change)

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return directions of impulses; see `contactlab.api.ImplicitContact`."""
        if not self.whole_steps:
            found = self.linearise(chosen)
            return found.normal, found.tangent
        stepped = ((rows, _within(rows.pair.own, chosen)) for rows in self.linear)
        normal, tangent = zip(*(rows.directions(within) for rows, within in stepped if len(within)), strict=True)
        across = [n * 0.0 if t is None else t for n, t in zip(normal, tangent, strict=True)]
        return stacked(normal), stacked(across) if self.friction else None


def _within(own: slice, chosen: Ints) -> Ints:
    """Return the chosen slots in a pair's slice `own`, counted from its first."""
    return np.asarray(chosen[(chosen >= own.start) & (chosen < own.stop)] - own.start, np.int32)


def _conditions(pairs: tuple[ContactPair, ...], multipliers: Floats, friction: bool) -> Conditions:
    k = multipliers.shape[1]
    bound = np.zeros((3, k if friction else 0))
    for pair in pairs:
        if pair.sliding is not None:
            bound[:, pair.own] = pair.sliding.of(slice(None))
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
