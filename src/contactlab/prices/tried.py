"""Prices of a scene and of its variants from trials of them, and from counted work where there are none."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from contactlab.prices.kept_trials import SceneTrial, Trials, trial_key
from contactlab.prices.price import Price, price_of

if TYPE_CHECKING:
    from contactlab.prices.price_list import PriceList
    from contactlab.scene.scene import Scene

REPEATED = 0.15  # of the price of a run that was made before: what two runs of a scene differ by
LATER = (0.5, 2.0)  # times what load steps of a trial cost: what later ones may
COUNTED = "counted work and prices of this machine"


class Pricing:
    """Prices of a scene and of variants of it.

    Where there is a trial of the scene, a variant without one costs its counted work times what the trial of the scene
    took over that of its own: they are made in the same way, and are compared. Without one all is counted.

    basis  what prices follow from, in words
    """

    def __init__(self, scene: Scene, prices: PriceList, trials: Trials) -> None:
        self.prices, self.trials, self.factor, self.basis = prices, trials, 1.0, COUNTED
        own = trials.get(trial_key(scene)) if trials else None
        if own is None or own.failed:
            self.trials = {}
        if own is None:
            return
        if own.failed:
            self.basis = f"{COUNTED}: a trial of {own.made} failed: {own.ended}"
            return
        self.basis = f"trials of this scene of {own.made}" + ("" if not own.ended else ", cut, and counted work")
        counted = price_of(scene, prices).cpu_s
        self.factor = tried_price(scene, prices, own).cpu_s / counted if counted else 1.0

    def price(self, scene: Scene) -> Price:
        """The price of the scene or of a variant. Raises RequestError where no model can be built of it."""
        trial = self.trials.get(trial_key(scene)) if self.trials else None
        if trial is None:
            return price_of(scene, self.prices).times(self.factor)
        return tried_price(scene, self.prices, trial)


def tried_price(scene: Scene, prices: PriceList, trial: SceneTrial) -> Price:
    """The price of a scene from a trial: what that took, or what follows from its begin.

    Of load steps the rest is taken to cost what those that were made cost; of explicit steps, to cost as much over
    counted work as they did: frames and steps are not spread evenly.
    """
    if not trial.ended:
        cost = trial.cpu_s
        least, most = (1.0 - REPEATED) * cost, (1.0 + REPEATED) * cost
        return Price(cost, least, most, trial.arrays_mib, trial.steps, iterations=trial.iterations, tried=trial.made)
    whole = price_of(scene, prices)
    if trial.failed:
        return replace(whole, reason=f"its trial of {trial.made} failed: {trial.ended}")
    memory = max(whole.arrays_mib, trial.arrays_mib)
    if trial.iterations and trial.done > 0.0:
        cost, steps, iterations = (value / trial.done for value in (trial.cpu_s, trial.steps, trial.iterations))
        return Price(cost, LATER[0] * cost, LATER[1] * cost, memory, steps, iterations=iterations, tried=trial.made)
    made = price_of(scene, prices, trial.length)
    return replace(whole.times(trial.cpu_s / made.cpu_s), arrays_mib=memory, unknown=(), tried=trial.made)
