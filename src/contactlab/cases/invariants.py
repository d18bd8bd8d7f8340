"""What no run may break, whatever a case asks: what every run said of itself, as measures of its cell."""

from __future__ import annotations

import math
from collections.abc import Mapping

from contactlab.api import Measure, Record
from contactlab.api.case import invariant, reported
from contactlab.results.invariants import Invariant


def invariants_of(done: Mapping[str, Record]) -> list[tuple[Measure, float]]:
    """The worst of each invariant over all runs and contacts of a cell, by what is allowed of it.

    A breach that a warning of its own code names is missed, and not silent.
    """
    worst: dict[str, Invariant] = {}
    for record in done.values():
        for data in record.summary.get("invariants", ()):
            one = Invariant.from_data(data)
            before = worst.get(one.name)
            if before is None or not _share(one) <= _share(before):
                worst[one.name] = one
    return [(_measure(one), one.value) for one in worst.values()]


def _share(one: Invariant) -> float:
    return one.value / one.limit if 0.0 < one.limit < math.inf else one.value


def _measure(one: Invariant) -> Measure:
    return invariant(one.name, one.limit, one.why, codes=(one.code,)) if one.limit < math.inf else reported(one.name)
