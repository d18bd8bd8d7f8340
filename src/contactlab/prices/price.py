"""What a run of a scene will cost by its counted work, before the first step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from contactlab.model.build import build
from contactlab.model.held_arrays import held_arrays
from contactlab.prices.calibrate import MIB, node_measure
from contactlab.prices.counts import Length, counts_of, total, unpriced
from contactlab.prices.expected import Expected, expected_length, touching

if TYPE_CHECKING:
    from contactlab.prices.price_list import PriceList
    from contactlab.scene.scene import Scene

SPREAD = 0.3  # of a price where the length of the run is known: some nine bundled runs in ten (build/docs/prices.md)


@dataclass(frozen=True)
class Price:
    """CPU time of the steps of a run [s], as expected and between bounds, and memory of its arrays [MiB].

    unknown     parts at work that have no price; the time is without them
    iterations  of Newton, of all steps; 0 in explicit runs
    tried       the day of the trial that it follows from; "" where it follows from counted work alone
    reason      why a run has no price: its trial failed
    """

    cpu_s: float
    least_s: float
    most_s: float
    arrays_mib: float
    steps: float
    unknown: Sequence[str] = ()
    iterations: float = 0.0
    tried: str = ""
    reason: str = ""

    @property
    def work(self) -> float:
        """Steps and iterations, as runs count their work."""
        return self.steps + self.iterations

    def times(self, factor: float) -> Price:
        """The same run where all of it costs so many times what was counted."""
        return replace(self, cpu_s=factor * self.cpu_s, least_s=factor * self.least_s, most_s=factor * self.most_s)


def price_of(scene: Scene, prices: PriceList, made: Length | None = None) -> Price:
    """The price of a scene as it is declared. Raises RequestError where no model can be built of it.

    made  the length of the run, where it is known
    """
    from contactlab.run.nested import coarser_levels
    from contactlab.run.prepare import schedule_of

    model = build(scene, scene.registry)
    schedule = schedule_of(model, scene)
    length = expected_length(scene, model, schedule) if made is None else Expected(made, made, made)
    counts = [counts_of(scene, model, *pair) for pair in zip(length, touching(scene, model), strict=True)]
    known: Mapping[str, float] = prices.units
    together = prices.together if model.explicit else 1.0
    least, usual, most = (together * total(found, known) for found in counts)
    unknown = unpriced(counts[1], known)
    held = sum(array.bytes for array in held_arrays(model, integrator=model.bound_integrator().advance)) / MIB
    if not model.explicit:
        held += prices.step_mib * node_measure(len(model.reference))
    for level in coarser_levels(scene.level) if schedule.skips else ():
        coarse = price_of(replace(scene, level=level), prices)
        least, usual, most = least + coarse.least_s, usual + coarse.cpu_s, most + coarse.most_s
    return Price(
        usual,
        least * (1.0 - SPREAD),
        most * (1.0 + SPREAD),
        held,
        length.usual.steps,
        unknown,
        length.usual.iterations,
    )
