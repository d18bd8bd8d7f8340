"""What a scene and each of its effects will cost: the bill of `contactlab compare --effects`, before any run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from contactlab.errors import RequestError, one_line
from contactlab.prices.kept_trials import NO_TRIALS, Trials
from contactlab.prices.lacking import lacking
from contactlab.prices.price import Price
from contactlab.prices.start import start_of
from contactlab.prices.tried import COUNTED, Pricing
from contactlab.studies.removable import Variant, variants

if TYPE_CHECKING:
    from contactlab.prices.price_list import PriceList
    from contactlab.scene.scene import Scene


@dataclass(frozen=True)
class EffectPrice:
    """What an effect will cost: the run with it less the run without it.

    declared  False: the scene lacks it, and would cost this more with it
    start_s   what it costs beside the steps: imports and kernels of its own [s]
    reason    why nothing is known: the scene without it is refused, its trial failed, or parts have no price
    refused, failed  the first, the second
    """

    effect: str
    declared: bool
    cpu_s: float = math.nan
    least_s: float = math.nan
    most_s: float = math.nan
    arrays_mib: float = math.nan
    start_s: float = 0.0
    reason: str = ""
    refused: bool = False
    failed: bool = False


@dataclass(frozen=True)
class Bill:
    """The price of a scene and of its effects; `start_s` and `process_mib` come on top of every run.

    basis  what the prices follow from, in words
    """

    whole: Price
    effects: Sequence[EffectPrice]
    start_s: float
    process_mib: float
    basis: str = COUNTED

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


def bill_of(scene: Scene, prices: PriceList, trials: Trials = NO_TRIALS) -> Bill:
    """The price of a scene and of each effect: in the order of the breakdown, then what installed parts would bring."""
    pricing = Pricing(scene, prices, trials)
    whole = pricing.price(scene)
    effects = [_effect(variant, scene, whole, pricing) for variant in (*variants(scene), *lacking(scene))]
    start_s, process_mib = start_of(scene, prices.start_s), start_of(scene, prices.process_mib)
    return Bill(whole, effects, start_s, process_mib, pricing.basis)


def _effect(variant: Variant, scene: Scene, whole: Price, pricing: Pricing) -> EffectPrice:
    unknown = partial(EffectPrice, variant.effect, variant.declared)
    try:
        changed = scene.with_(variant.changes)
        other = pricing.price(changed)
    except RequestError as error:
        return unknown(reason=one_line(error), refused=True)
    sign = 1.0 if variant.declared else -1.0
    memory = sign * (whole.arrays_mib - other.arrays_mib)
    if other.reason:
        return unknown(arrays_mib=memory, reason=other.reason, failed=True)
    rich, poor = (whole, other) if variant.declared else (other, whole)
    if missing := [part for part in rich.unknown if part not in poor.unknown]:
        return unknown(arrays_mib=memory, reason=f"unknown: no price is known for {', '.join(missing)}")
    ends = [getattr(rich, name) - getattr(poor, name) for name in ("least_s", "cpu_s", "most_s")]
    starts = pricing.prices.start_s
    start_s = sign * (start_of(scene, starts) - start_of(changed, starts))
    return EffectPrice(variant.effect, variant.declared, ends[1], min(ends), max(ends), memory, start_s)
