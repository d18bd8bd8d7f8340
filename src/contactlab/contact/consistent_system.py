"""All contact pairs of a model, whose forces act along the derivatives of the gaps (theory/contact-energy.md)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from contactlab.api import ExplicitEnforcement, Floats, Solve, State
from contactlab.contact.explicit_system import Columns, ContactSystem, Reduced
from contactlab.contact.gradients import ModelGradients, PairGradients, push_facets, with_ends
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.kernels.contact.factored_rows import allow_constant_motion
from contactlab.kernels.contact.gap_gradients import allow_motion
from contactlab.kernels.contact.pair import largest_sideways

ROUND = 1e-9  # segment lengths: an offset this far across a normal turns it by round-off


class ConsistentContactSystem(ContactSystem):
    """`ContactSystem` whose rows are the derivatives of the gaps at the start of the step."""

    consistent: ClassVar[bool] = True

    def __init__(self, pairs: tuple[ContactPair, ...], enforcement: ExplicitEnforcement, state: State) -> None:
        super().__init__(pairs, enforcement, state)
        # finished constraints have weights that are the derivatives of their gaps already
        self.gradients = {n: PairGradients(pair) for n, pair in enumerate(pairs) if isinstance(pair, OperatorPair)}
        for pair in pairs:
            if isinstance(pair, OperatorPair):
                pair.coupling.let_go()
        self.velocity = state["velocity"]

    def calls_per_step(self) -> Counter[str]:
        """Count constraints once; slips use the gradients, which need no normals at the start of the step."""
        calls = super().calls_per_step()
        del calls["contact normals"]
        return Counter({call: min(count, len(self.passes)) for call, count in calls.items()})

    def _reductions(self, pairs: tuple[ContactPair, ...]) -> tuple[Reduced, ...]:
        """Return rows by overlap ends, and rows by columns if closest points are joined."""
        if not self.enforcement.factored:
            return ()
        found: list[Reduced] = []
        if len(known := with_ends(pairs)) == len(pairs):
            found.append(ModelGradients(known, self.enforcement, self.state))
        if len(closest := joined(self.passes)) == len(self.passes):
            found.append(ConstantColumns(closest, self.enforcement, self.state))
        return tuple(found)

    def _update(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> None:
        for pair, memory in zip(self.passes, self.memories, strict=True):
            pair.update(current, memory)

    def _append(self, number: int, entries: int, margin: float, current: Floats, predicted: Floats) -> int:
        rows, first, pair = self.rows, self.rows.count, self.passes[number]
        if number in self.gradients:
            gradients = self.gradients[number]
            entries = gradients.append_rows(rows, entries, margin, self.multipliers, self.memories[number])
        else:
            entries = super()._append(number, entries, margin, current, predicted)
        if entries >= 0:
            self._advance(pair, first, current, predicted)
            push_facets(pair, rows, self.state, first)
        return entries

    def _advance(self, pair: ContactPair, first: int, current: Floats, predicted: Floats) -> None:
        """Set what the rows of a pair, from `first` on, have to hold at the end of the step."""
        # pushing out an initial overlap adds energy on purpose
        strict, rows = not pair.pushes_overlaps_out, self.rows
        allow_motion(
            first, rows.count, rows.packed.address, current, predicted, self.velocity, self.state.last_dt, strict
        )


class ConstantColumns(Columns):
    """Rows along normals that are exact derivatives of the gaps, as closest points are joined."""

    pairs: Sequence[OperatorPair]

    def __init__(self, pairs: Sequence[OperatorPair], enforcement: ExplicitEnforcement, state: State) -> None:
        super().__init__(pairs, enforcement)
        self.state, self.offset = state, np.zeros(len(self.factors.gap))

    def assemble(self, current: Floats, predicted: Floats) -> bool:
        """See `Reduced`; False if joined points are offset across the normal."""
        if any(largest_sideways(pair.address) > ROUND for pair in self.pairs):
            return False
        super().assemble(current, predicted)
        rows, velocity, dt = self.factors, self.state["velocity"], self.state.last_dt
        allow_constant_motion(rows.count, rows.packed.address, current, predicted, velocity, dt, self.offset)
        for pair in self.pairs:
            push_facets(pair, rows, self.state, offset=self.offset)
        return True

    def solve(self, compliance: Floats, multipliers: Floats, force: Floats) -> Solve | None:
        """See `Reduced`; the remaining gaps belong to the end of the step."""
        done = super().solve(compliance, multipliers, force)
        if done is not None:
            self.factors.left[: self.factors.count] += self.offset[: self.factors.count]
        return done


def joined(pairs: Sequence[ContactPair]) -> list[OperatorPair]:
    """Return the pairs whose constraints join closest points, and can be given by columns."""
    return [
        pair
        for pair in pairs
        if isinstance(pair, OperatorPair)
        and pair.algorithm.closest_points
        and pair.friction is None
        and not pair.pushes_overlaps_out
    ]
