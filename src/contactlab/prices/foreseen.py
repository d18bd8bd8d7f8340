"""What a scene and each of its effects will cost: the bill of `contactlab compare --effects`, before any run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from contactlab.errors import RequestError, one_line
from contactlab.model.build import build
from contactlab.model.held_arrays import held_arrays
from contactlab.prices.calibrate import MIB, node_measure
from contactlab.prices.counts import counts_of, total, unpriced
from contactlab.prices.expected import expected_length, touching
from contactlab.prices.lacking import lacking
from contactlab.studies.removable import Variant, variants

if TYPE_CHECKING:
    from contactlab.prices.price_list import PriceList
    from contactlab.scene.scene import Scene

SPREAD = 0.3  # of a price where the length of the run is known: some nine bundled runs in ten (docs/prices.md)


@dataclass(frozen=True)
class Price:
    """CPU time of the steps of a run [s], as expected and between bounds, and memory of its arrays [MiB].

    unknown  parts at work that have no price; the time is without them
    """

    cpu_s: float
    least_s: float
    most_s: float
    arrays_mib: float
    steps: float
    unknown: Sequence[str] = ()


@dataclass(frozen=True)
class EffectPrice:
    """What an effect will cost: the run with it less the run without it.

    declared  False: the scene lacks it, and would cost this more with it
    reason    why nothing is known: the scene without it is refused, or parts have no price
    refused   the former
    """

    effect: str
    declared: bool
    cpu_s: float = math.nan
    least_s: float = math.nan
    most_s: float = math.nan
    arrays_mib: float = math.nan
    reason: str = ""
    refused: bool = False


@dataclass(frozen=True)
class Bill:
    """The price of a scene and of its effects; `start_s` and `process_mib` come on top of every run."""

    whole: Price
    effects: Sequence[EffectPrice]
    start_s: float
    process_mib: float

    @property
    def summary(self) -> dict[str, float]:
        """The single numbers: CPU time [s] of the whole run and of its steps, and memory [MiB]."""
        whole = self.whole
        return {
            "cpu_s": self.start_s + whole.cpu_s,
            "least_s": self.start_s + whole.least_s,
            "most_s": self.start_s + whole.most_s,
            "steps_s": whole.cpu_s,
            "memory_mib": self.process_mib + whole.arrays_mib,
        }


def price_of(scene: Scene, prices: PriceList) -> Price:
    """The price of a scene as it is declared. Raises RequestError where no model can be built of it."""
    from contactlab.run.nested import coarser_levels
    from contactlab.run.prepare import schedule_of

    model = build(scene, scene.registry)
    schedule = schedule_of(model, scene)
    length = expected_length(scene, model, schedule)
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
    )


def bill_of(scene: Scene, prices: PriceList) -> Bill:
    """The price of a scene and of each effect: in the order of the breakdown, then what installed parts would bring."""
    whole = price_of(scene, prices)
    effects = [_effect(variant, scene, whole, prices) for variant in (*variants(scene), *lacking(scene))]
    return Bill(whole, effects, prices.start_s, prices.process_mib)


def _effect(variant: Variant, scene: Scene, whole: Price, prices: PriceList) -> EffectPrice:
    try:
        other = price_of(scene.with_(variant.changes), prices)
    except RequestError as error:
        return EffectPrice(variant.effect, variant.declared, reason=one_line(error), refused=True)
    rich, poor = (whole, other) if variant.declared else (other, whole)
    memory = rich.arrays_mib - poor.arrays_mib
    if unknown := [part for part in rich.unknown if part not in poor.unknown]:
        reason = f"unknown: no price is known for {', '.join(unknown)}"
        return EffectPrice(variant.effect, variant.declared, arrays_mib=memory, reason=reason)
    ends = [getattr(rich, name) - getattr(poor, name) for name in ("least_s", "cpu_s", "most_s")]
    return EffectPrice(variant.effect, variant.declared, ends[1], min(ends), max(ends), memory)
