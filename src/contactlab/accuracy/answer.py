"""The answer of a search: the cheapest trial that keeps the error, else the best that can be said."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from contactlab.accuracy.configuration import Configuration
from contactlab.accuracy.judged import ForcesJudged, highest_at_an_end
from contactlab.accuracy.remaining import Truth
from contactlab.accuracy.trials import EQUAL, FINER, Place, Trials
from contactlab.parts.registry import split_spec


@dataclass(frozen=True)
class Tried:
    """Trial as it is reported: `error` is NaN without a measure, `cpu_s` are the CPU times of its runs."""

    configuration: str
    level: int
    status: str
    reason: str
    error: float
    cpu_s: tuple[float, ...]


@dataclass(frozen=True)
class Chosen:
    """Answer of a search.

    verdict         "ok" if the upper end of `error_interval` is below the error that was asked for, else "cannot"
    choice          scene keys and values of the best that is known
    error           of the contact pressure, relative, in L2 (of forces if `judged` says so); nan if unknown
    error_interval  with all that is uncertain; None where nothing bounds the error
    cost_s          CPU time of the chosen run without start and compilation [s], a median
    judged          what runs were compared by
    reference       what they were compared with
    uncertainty     relative error of the reference
    spent_s         CPU time of all trials [s]
    """

    verdict: Literal["ok", "cannot"]
    choice: Mapping[str, Any]
    error: float
    error_interval: tuple[float, float] | None
    cost_s: float
    why: str
    tried: Sequence[Tried]
    configuration: Configuration
    name: str
    level: int
    judged: str = ""
    reference: str = ""
    uncertainty: float = math.nan
    spent_s: float = 0.0

    @property
    def settings(self) -> Mapping[str, Any]:
        """The choice, for `scene.with_`."""
        return self.choice


def answer(trials: Trials) -> Chosen:
    """Answer by what is known now; there is always something to choose."""
    truth = trials.truth()
    met = trials.meeting(truth) if truth is not None else []
    finished = [place for place, trial in trials.all.items() if trial.finished]
    if met:
        # of those that cost next to nothing the most accurate
        cheap = [place for place in met if trials.cost(place) <= EQUAL]
        place = min(cheap, key=lambda place: trials.errors(place[0])[place[1]]) if cheap else min(met, key=trials.cost)
    elif finished:
        place = _best_known(trials, finished, truth)
    else:
        own = split_spec("contact", trials.scene.contacts[0].algorithm, "")[0]
        first = Configuration(own), 1
        place = max(trials.all, key=lambda p: trials.all[p].reached, default=first)
    configuration, level = place
    error, interval = math.nan, None
    if truth is not None:
        error = trials.errors(configuration).get(level, math.nan)
        if trials.bounded() and math.isfinite(error):
            doubt = truth.uncertainty + trials.doubt
            interval = max(0.0, error - doubt), error + doubt
            error = error or truth.uncertainty  # the reference itself
    ok = interval is not None and bool(met)
    why = _why_ok(trials, met) if ok else _why_not(trials, place, met, truth)
    return Chosen(
        "ok" if ok else "cannot", configuration.changes(trials.scene.data, level), error, interval,
        trials.cost(place) if place in trials.all else math.nan, why, _tried(trials), configuration,
        trials.name(configuration), level, trials.judged().what, truth.words if truth else "",
        truth.uncertainty if truth else math.nan, trials.spent,
    )  # fmt: skip


def _best_known(trials: Trials, finished: Sequence[Place], truth: Truth | None) -> Place:
    """The smallest error within the budget; the cheapest by forces where errors cannot be told apart; else the finest.

    What the reference does not know of itself tells nothing between two runs. Those whose forces are as exact as
    pressures should be are then alike, and the cheapest of them is as good as the dearest.
    """
    fitting = [place for place in finished if trials.cost(place) <= trials.wish.budget] or list(finished)
    known = {place: trials.errors(place[0]).get(place[1], math.inf) for place in fitting if truth is not None}
    least = min(known.values(), default=math.inf)
    if truth is None or least == math.inf:
        return max(fitting, key=lambda p: (p[1], not p[0].exchanged, -trials.cost(p)))
    if truth.uncertainty < trials.wish.error:
        return min(fitting, key=lambda place: (known[place], trials.cost(place)))
    alike = [place for place in fitting if known[place] <= least + truth.uncertainty]
    exact = [place for place in alike if _off_by_force(trials, place) <= trials.wish.error]
    return min(exact, key=trials.cost) if exact else min(alike, key=lambda place: _off_by_force(trials, place))


def _remedy(trials: Trials, truth: Truth) -> str:
    """A way to a pressure that is better known."""
    if trials.pressed() and any(map(highest_at_an_end, truth.value.values())):
        return "a pressure has no limit below a sharp edge: round it"
    if truth.level >= FINER[-1]:
        return "cells are too large for it on the finest mesh that is tried: write smaller ones where it acts"
    return "a longer --search may help"


def _off_by_force(trials: Trials, place: Place) -> float:
    """Relative difference of forces from those of the finest run, the dearest of them."""
    finest = max((p for p in trials.all if trials.all[p].finished), key=lambda p: (p[1], trials.cost(p)))
    return ForcesJudged.apart(trials.all[place].forces, trials.all[finest].forces)


def _error_of(trials: Trials) -> str:
    return "pressure error" if trials.pressed() else "error of the forces (nothing is pressed at the end)"


def _why_ok(trials: Trials, met: Sequence[Place]) -> str:
    text = f"the cheapest of {len(met)} trials that keep the {_error_of(trials)} below {100.0 * trials.wish.error:g} %"
    costs = sorted(trials.cost(place) for place in met)
    return text + (f"; the next one takes {costs[1]:.2g} CPU s" if len(costs) > 1 else "")


def _why_not(trials: Trials, place: Place, met: Sequence[Place], truth: Truth | None) -> str:
    asked = f"{100.0 * trials.wish.error:g} %"
    trial = trials.all.get(place)
    if trial is None or not trial.finished:
        text = "no trial has finished"
        text += f"; this one came furthest ({trial.status}: {trial.reason[:200]})" if trial is not None else ""
    elif truth is None:
        text = "no configuration finished on two meshes, so nothing bounds an error; judged by robustness and cost"
    elif not trials.bounded():
        text = "pressures cannot be judged (they are no function of a position), so nothing bounds their "
        text += "error; judged by forces at the end or in the mean, by robustness and by cost: "
        text += f"the forces are {'' if met else 'not '}within {asked} of those of the finest meshes"
    else:
        text = f"no trial keeps the {_error_of(trials)} below {asked} with all that is uncertain: "
        text += f"{100.0 * truth.uncertainty:.2g} % of the reference"
        text += f", {100.0 * trials.doubt:.2g} % of time and load steps" if trials.doubt > 0.0 else ""
        forces = f"its forces differ by {100.0 * _off_by_force(trials, place):.2g} % from those of the finest run"
        if truth.uncertainty >= trials.wish.error:
            text += f"; pressures do not tell runs apart: the cheapest whose forces are right to {asked} is taken"
            text += f"; {_remedy(trials, truth)}"
        text += f"; {forces}"
    used = "stopped early" if trials.stopped else f"{trials.spent:.3g} of {trials.wish.search:g} CPU s used"
    return f"the best I can say: {text} ({used})"


def _tried(trials: Trials) -> list[Tried]:
    found = [
        Tried(trials.name(place[0]), place[1], trial.status, trial.reason, trials.error(place), tuple(trial.costs))
        for place, trial in trials.all.items()
    ]
    return sorted(found, key=lambda tried: (tried.configuration, tried.level))
