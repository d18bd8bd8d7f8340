"""All contact pairs of a model, whose forces act along the derivatives of the gaps (theory/contact-energy.md)."""

from __future__ import annotations

from collections import Counter
from time import perf_counter
from typing import ClassVar

import numpy as np

from contactlab.api import ExplicitEnforcement, FactoredRows, Floats, Rows, Solve, State
from contactlab.contact.explicit_system import ContactSystem
from contactlab.contact.gradients import ModelGradients, PairGradients, with_ends
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.contact.start_gaps import FacetOverlap
from contactlab.kernels.contact.factored_rows import allow_constant_motion, largest_sideways
from contactlab.kernels.contact.gap_gradients import allow_motion

ROUND = 1e-9  # of a segment: what lies that far across a normal turns it by round-off


class ConsistentContactSystem(ContactSystem):
    """As `ContactSystem`, with rows that are the derivatives of the gaps where the step starts."""

    consistent: ClassVar[bool] = True

    def __init__(self, pairs: tuple[ContactPair, ...], enforcement: ExplicitEnforcement, state: State) -> None:
        super().__init__(pairs, enforcement, state)
        known, self.ends = with_ends(self.factorable), None
        if enforcement.factored and len(known) == len(self.factorable):
            self.ends = ModelGradients(known, len(state["displacement"]))
        columns = FactoredRows.allocate(len(self.rows.gap), 8 * len(self.rows.gap)) if _closest(self) else None
        self.columns, self.offset = columns, np.zeros(len(self.rows.gap))
        self.factored = self.ends.rows.factors if self.ends is not None else columns
        # finished conditions have weights that are the derivatives of their gaps already
        self.gradients = {n: PairGradients(pair) for n, pair in enumerate(pairs) if isinstance(pair, OperatorPair)}
        for pair in pairs:
            if isinstance(pair, OperatorPair):
                pair.coupling.let_go()
        # an overlap of the start that is pushed out puts energy in on purpose
        self.strict = [not pair.pushes_overlaps_out for pair in pairs]
        self.velocity = state["velocity"]
        self.facets = [(pair.first_slot, own) for pair in pairs if isinstance(own := pair.start_gaps, FacetOverlap)]

    def calls_per_step(self) -> Counter[str]:
        """Conditions once; slips are measured with the gradients, which need no normals of the start of the step."""
        calls = super().calls_per_step()
        del calls["contact normals"]
        return Counter({call: min(count, len(self.passes)) for call, count in calls.items()})

    def _update(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> None:
        for pair, memory in zip(self.passes, self.memories, strict=True):
            pair.update(current, memory)

    def _solve_factored(self, *where: Floats) -> Solve | None:
        return self._solve_by_ends(*where) or self._solve_by_columns(*where)

    def _solve_by_ends(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve | None:
        """By rows before their coupling is inverted; None where that cannot be."""
        ends, self.rows.count = self.ends, 0
        memories = [m for m, pair in zip(self.memories, self.passes, strict=True) if not pair.at_corners]
        if ends is None or not ends.assemble(memories):
            return None
        self.factored = ends.rows.factors
        ends.allow_motion(predicted, current, self.velocity, self.state.last_dt)
        self._push_facets(self.factored, ends.rows.offset)
        asked = perf_counter()
        done = self.enforcement.solve_gradients(ends.rows, compliance, self.multipliers, force)
        self.solution_s += perf_counter() - asked
        if done is None:
            self.factored.count = 0  # these rows are not those that recorders are to see
        return done

    def _solve_by_columns(self, *where: Floats) -> Solve | None:
        """By columns, where closest points are joined: their rows are derivatives as they are; None elsewhere."""
        if self.columns is None:
            return None
        self.columns.count = 0
        pairs = (pair for pair in self.passes if isinstance(pair, OperatorPair))
        if any(largest_sideways(pair.address) > ROUND for pair in pairs):
            return None
        self.factored = self.columns
        done, rows = super()._solve_factored(*where), self.factored
        self.columns = rows
        if done is not None:
            rows.left[: rows.count] += self.offset[: rows.count]
        return done

    def _assemble_factored(self, current: Floats, predicted: Floats) -> FactoredRows:
        rows, velocity, dt = super()._assemble_factored(current, predicted), self.velocity, self.state.last_dt
        allow_constant_motion(rows.count, rows.packed.address, current, predicted, velocity, dt, self.offset)
        self._push_facets(rows, self.offset)
        return rows

    def _assemble(self, margin: float, current: Floats, predicted: Floats) -> None:
        super()._assemble(margin, current, predicted)
        self._push_facets(self.rows, self.offset)

    def _append(self, number: int, entries: int, margin: float, current: Floats, predicted: Floats) -> int:
        rows, first = self.rows, self.rows.count
        if number in self.gradients:
            gradients = self.gradients[number]
            entries = gradients.append_rows(rows, entries, margin, self.multipliers, self.memories[number])
        else:
            entries = super()._append(number, entries, margin, current, predicted)
        if entries >= 0:
            self._advance(rows, first, current, predicted, self.strict[number])
        return entries

    def _push_facets(self, rows: Rows | FactoredRows, offset: Floats) -> None:
        """Let weak overlaps of the start be pushed out by what comes to count of them: rows hold u + d, two steps."""
        time, dt = self.state.time, self.state.last_dt
        for first, facets in self.facets:
            if (pushed := facets.pushed(max(0.0, time - dt), time + dt)) is not None:
                slot = rows.slot[: rows.count] - first
                own = np.flatnonzero((slot >= 0) & (slot < len(pushed)))
                rows.gap[own] += pushed[slot[own]]
                offset[own] -= pushed[slot[own]]

    def _advance(self, rows: Rows, first: int, current: Floats, predicted: Floats, strict: bool) -> None:
        """What the rows from `first` on have to hold at the end of the step."""
        allow_motion(
            first, rows.count, rows.packed.address, current, predicted, self.velocity, self.state.last_dt, strict
        )


def _closest(system: ContactSystem) -> bool:
    """Whether all conditions join closest points, and can be given by columns."""
    return system.enforcement.factored and all(
        isinstance(pair, OperatorPair)
        and pair.algorithm.closest_points
        and pair.friction is None
        and not pair.pushes_overlaps_out
        for pair in system.passes
    )
