"""All contact pairs of a model: one list of constraints, one solve by `enforcement`, a plugin component."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from contactlab.api import ExplicitEnforcement, FactoredGradients, FactoredRows, Floats, GapRows, Rows, Solve, State
from contactlab.contact.corner_pair import CornerPair
from contactlab.contact.friction import taking_tractions, varying
from contactlab.contact.pair import ContactPair, shown
from contactlab.contact.sliding import FOLLOWED
from contactlab.errors import WrongAnswer
from contactlab.kernels.contact.pair import extrapolate, tangential_work

MARGIN = 0.1  # segment lengths: constraints with a larger gap cannot close within a step
GROW = 1.5
ROUNDS = 20  # most solves of a step in which bounds follow slips


class ContactSystem:
    """The pairs and the enforcement they share. Implements `contactlab.api.ContactEquations`.

    `seconds` counts the wall time of contact, `solution_s` its part in the enforcement. `consistent` is True if
    forces act along the derivatives of the gaps.
    `compliance` belongs to the last solve: displacement (N, 2) [mm/N] per contact force within its step.
    `passes` are all pairs, an `OperatorPair` for each mortar; `pairs` are in reports (see `ContactPair.second`).
    `reduced` are rows before the couplings T of their multipliers are inverted, tried in this order before `rows`;
    `factored` are the rows that the last step began with.
    """

    consistent: ClassVar[bool] = False

    def __init__(self, pairs: tuple[ContactPair, ...], enforcement: ExplicitEnforcement, state: State) -> None:
        self.pairs, self.passes = shown(pairs), pairs
        self.enforcement, self.state = enforcement, state
        # the enforcement itself, unless it has methods of older names
        self.solver = OlderNames(enforcement) if OlderNames.has(enforcement) else enforcement
        self.multipliers, self.before = state["multipliers"], state["multipliers_before"]
        self.friction = any(pair.friction is not None for pair in pairs)
        self.memories = [pair.memory_in(state) for pair in pairs]
        self.margin = MARGIN * min(pair.size for pair in pairs)
        self.rows = Rows.allocate(sum(pair.slots for pair in pairs), 64, self.friction)
        self.factored: FactoredRows | None = None
        self.cornered = [(pair.corners, pair) for pair in pairs if isinstance(pair, CornerPair)]
        self.reduced = self._reductions(tuple(pair for pair in pairs if not pair.at_corners))
        if self.reduced:
            self.factored = self.reduced[0].rows.factors
        self.last, self.compliance = Solve(0, 0.0, 0, 0.0), np.zeros_like(state["displacement"])
        self.seconds = self.solution_s = 0.0
        self.varying = varying(pairs, state)

    def calls_per_step(self) -> Counter[str]:
        """Return how many calls of each method of the algorithms a step makes."""
        return sum((Counter(pair.calls_per_step()) for pair in self.passes), Counter())

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Update the pairs, make rows and find forces; see `contactlab.api.ContactEquations`."""
        began, self.compliance = perf_counter(), compliance
        self._update(predicted, current, compliance, force)
        self.last = self._solve(predicted, current, compliance, force)
        self.seconds += perf_counter() - began
        return self.last

    def _reductions(self, pairs: tuple[ContactPair, ...]) -> tuple[Reduced, ...]:
        """Return the rows of the `pairs` that are tried before the rows that are written out."""
        if self.enforcement.factored and not self.friction and all(pair.factored for pair in pairs):
            return (Columns(pairs),)
        return ()

    def _update(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> None:
        # normals and weights belong to the final nodal positions: predicted, pushed by the last forces.
        # `predicted` alone is off by dt^2 f/m, some per cent of a segment in pressed zones.
        for pair, memory in zip(self.passes, self.memories, strict=True):
            pair.update_pushed(predicted, compliance, force, memory)
            if pair.friction is not None and not pair.idle:
                pair.compute_start_normals(current, memory)

    def rate(self, step: float) -> float:
        """Return the largest eigenvalue [1/s2] added by contact; 0, as exact multipliers do not limit the step.

        step  [s] stable step without contact
        """
        return 0.0

    @property
    def stiffened(self) -> bool:
        """True if `rate` has grown since the step was chosen."""
        return False

    @property
    def stored_since_start(self) -> float:
        """Energy [mJ] stored in surfaces beyond their energy at the start; zero under exact multipliers."""
        return 0.0

    def slips(self) -> Floats:
        """Return slips (k,) [mm] of the last step with friction: prediction of the rows, and change by the forces."""
        return slips(self.rows, self.multipliers.shape[1], self.compliance, self.state["contact_force"])[0]

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Work and dissipation of the tangential forces; see `contactlab.api.ContactEquations`."""
        if not self.friction:
            return 0.0, 0.0
        if self.varying:
            slip, _ = slips(self.rows, self.multipliers.shape[1], compliance, force)
            for pair, sliding in self.varying:
                sliding.accept(pair.cover, slip[pair.own], self.multipliers[0, pair.own], pair.idle)
        work, dissipation = tangential_work(
            self.rows.count, self.rows, self.multipliers, mean_velocity, dt, compliance, force
        )
        return work, dissipation

    @property
    def begin(self) -> tuple[Callable[[float, float], None], ...]:
        """Functions called with the end and the length [s] of each step before it: bounds that vary."""
        return tuple(sliding.begin_step for _, sliding in self.varying)

    @property
    def follow(self) -> tuple[Callable[[float, float], None], ...]:
        """Functions called with the end and the length [s] of each step after it: bounds that follow stresses."""
        return taking_tractions(self.varying)

    def _enforce(self, rows: GapRows, compliance: Floats, force: Floats) -> Any:
        """Solve for the forces of rows of any form. Return a `Solve`; None if reduced rows have no solution."""
        began = perf_counter()
        # by default `ForwardIncrement.solve`: of consistent rows `contactlab_dynamics.active_set.solve_gradients`
        done = self.solver.solve(rows, compliance, self.multipliers, force)
        self.solution_s += perf_counter() - began
        if type(done) is not Solve and (done is not None or rows is self.rows):
            raise WrongAnswer(f"{type(self.enforcement).__name__}: solve gave {type(done).__name__}, needed: Solve")
        return done

    def _follow(self, done: Solve, again: Callable[[], Solve], compliance: Floats, force: Floats) -> Solve:
        """Solve again until the bounds of laws that vary belong to the slip of this step."""
        slot, bound = self.rows.slot[: self.rows.count], self.rows.bound
        own = [np.flatnonzero((slot >= pair.own.start) & (slot < pair.own.stop)) for pair, _ in self.varying]
        change = 0.0
        for _ in range(ROUNDS):
            slip, give = slips(self.rows, self.multipliers.shape[1], compliance, force)
            change = max(
                sliding.follow(pair.cover, slip[pair.own], give[pair.own], self.multipliers[:, pair.own])
                for pair, sliding in self.varying
            )
            if change <= FOLLOWED:
                return done
            for (pair, sliding), rows in zip(self.varying, own, strict=True):
                bound[:, rows] = sliding.of(slot[rows] - pair.first_slot)
            done = again()
        return done._replace(residual=max(done.residual, change))

    def _solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        # extrapolating the normal forces of the last two steps saves a quarter of the iterations
        extrapolate(self.multipliers[0], self.before)
        where = predicted, current, compliance, force
        # constraints at corners, or points there that can close, have no reduced rows
        if not any(
            corners.moved or (not points.idle and points.gaps[:, 0].min() <= self.margin)
            for corners, points in self.cornered
        ):
            self.rows.count = 0
            for reduced in self.reduced:
                if reduced.assemble(current, predicted):
                    self.factored = f = reduced.rows.factors
                    done: Solve | None = self._enforce(reduced.rows, compliance, force)
                    if done is not None:
                        if reduced.offset is not None:
                            f.left[: f.count] += reduced.offset[: f.count]
                        return done
        if self.factored is not None:
            self.factored.count = 0  # output writers are not to see these rows
        return self._solve_full(*where)

    def _solve_full(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        margin, warm = self.margin, self.multipliers.copy()
        while True:
            self._assemble(margin, current, predicted)
            done: Solve = self._enforce(self.rows, compliance, force)
            if self.varying:
                done = self._follow(done, lambda: self._enforce(self.rows, compliance, force), compliance, force)
            # a left-out row could have closed only if nodes were moved by a good part of the margin
            if 4.0 * done.largest_correction <= margin or margin == np.inf:
                return done
            margin = np.inf
            self.multipliers[:] = warm

    def _assemble(self, margin: float, current: Floats, predicted: Floats) -> None:
        while True:
            self.rows.count = entries = 0
            for number, pair in enumerate(self.passes):
                if pair.idle:
                    continue
                entries = self._append(number, entries, margin, current, predicted)
                if entries < 0:
                    break
            if entries >= 0:
                return
            rows, nodes = self.rows, sum(len(pair.slave.nodes) + len(pair.master.nodes) for pair in self.passes)
            entries = int(GROW * len(rows.node)) + nodes
            self.rows = Rows.allocate(len(rows.gap), entries // max(1, len(rows.gap)) + 1, self.friction)

    def _append(self, number: int, entries: int, margin: float, current: Floats, predicted: Floats) -> int:
        """Append the rows of a pair. Return the next free entry, or -1 if there is no room."""
        return self.passes[number].append_rows(self.rows, entries, margin, self.multipliers, current)


class Reduced(ABC):
    """Rows of a model before the couplings T of their multipliers are inverted."""

    rows: FactoredRows | FactoredGradients
    offset: Floats | None = None
    """Gaps (k,) [mm] to add to the gaps that a solve leaves, if it does not add them."""

    @abstractmethod
    def assemble(self, current: Floats, predicted: Floats) -> bool:
        """Make the rows for a step between these positions (N, 2); False if there are no such rows."""


class Columns(Reduced):
    """Rows along normals: columns of D and M, and the factors of T."""

    pairs: Sequence[ContactPair]
    rows: FactoredRows

    def __init__(self, pairs: Sequence[ContactPair]) -> None:
        self.pairs, slots = pairs, sum(pair.slots for pair in pairs)
        self.rows = FactoredRows.allocate(slots, 8 * slots)

    def assemble(self, current: Floats, predicted: Floats) -> bool:
        """Make the rows of all pairs as last updated."""
        while True:
            self.rows.count = 0
            if all(pair.append_factored(self.rows) for pair in self.pairs):
                return True
            self.rows = FactoredRows.allocate(len(self.rows.gap), int(GROW * len(self.rows.node)) + 64)


class OlderNames:
    """An enforcement with methods of older names for reduced rows, `solve_factored` or `solve_gradients`."""

    def __init__(self, enforcement: ExplicitEnforcement) -> None:
        self.enforcement = enforcement

    @staticmethod
    def has(enforcement: ExplicitEnforcement) -> bool:
        """Return whether the class of an enforcement overrides such a method."""
        cls, base = type(enforcement), ExplicitEnforcement
        return (cls.solve_factored, cls.solve_gradients) != (base.solve_factored, base.solve_gradients)

    def solve(self, rows: GapRows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve | None:
        """Call the method for this form of rows."""
        if isinstance(rows, FactoredRows):
            return self.enforcement.solve_factored(rows, compliance, multipliers, force)
        if isinstance(rows, FactoredGradients):
            return self.enforcement.solve_gradients(rows, compliance, multipliers, force)
        return self.enforcement.solve(rows, compliance, multipliers, force)


def slips(rows: Rows, slots: int, compliance: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Slip (slots,) [mm] of all multipliers, and its change by a force of 1 N along the slip (slots,) [mm/N].

    Slip is the prediction of the rows plus the change by the forces of the step.
    """
    k = rows.count
    slot, end = rows.slot[:k], rows.start[k]
    of = np.repeat(slot, np.diff(rows.start[: k + 1]))
    node, weight = rows.node[:end], rows.tangent_weight[:end]
    moved = weight * compliance[node]
    slip = np.bincount(slot, rows.slip[:k], slots) + np.bincount(of, (moved * force[node]).sum(axis=1), slots)
    return np.asarray(slip, np.float64), np.bincount(of, (moved * weight).sum(axis=1), slots).astype(np.float64)
