"""Choosing for one scene: the cheapest algorithm, slave, element, integrator, surfaces and level for an error."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from contactlab.accuracy.answer import Chosen, answer
from contactlab.accuracy.configuration import (
    Configuration,
    algorithms_for,
    elements_for,
    exchangeable,
    integrators_for,
    possible,
)
from contactlab.accuracy.remaining import Truth, beside, ranked
from contactlab.accuracy.trials import EQUAL, FINER, GROWTH, Place, Plan, Said, Trials, Wish
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.run.attempts import first_that_fits
from contactlab.scene.scene import Scene

__all__ = ["Chosen", "Wish", "choose_plan"]

LEVELS = (1, 2, 3, 4, 6, 8)
"""Levels that are chosen from."""
CLEAR = 6.0
"""Times that the error asked for exceeds the uncertainty of what it is measured against, while there is time.

With an error C h and costs of h^-2, a sixth costs 1.4 times as much as an exact solution would, a third 2.2 times.
"""
SURVEY, REFINED, TRIED = 0.3, 0.65, 0.9
"""Parts of the search after which the survey of coarse levels, the finer runs and the trials begin no further run."""
LEAST_LIMIT = 2.0
"""CPU time [s] that it may take in any case, while the search is longer than that."""
CLIMBERS = 4
"""Configurations that go beyond level 2 for the sake of others at most."""
STUBBORN = 0.06
"""Of the search that a run of the survey may take."""
FAR = 4.0
"""Times the cheapest run of its level that it may take: for so much there is one on a mesh nearly twice as fine."""
BEST_ORDER = 1.5
"""Order of convergence that a trial may hope for."""
LUCK = 0.6
"""Times the error hoped for that one may have whose edges of contact fall well in their cells: once one is found."""
REPEATS = 3
"""Timed runs of those that may be the cheapest; costs are medians."""
STEPS = 0.25
"""Of the error that may be left by load steps: at costs n h^-2 the least for errors a h + b / n leaves them a third."""
DOUBLINGS = 3
"""Times that load steps are doubled at most where the answer depends on them."""


def choose_plan(
    scene: Scene, wish: Wish, registry: Registry, said: Said = lambda line: None
) -> Generator[Sequence[Any], Sequence[Any], Chosen]:
    """Try configurations on coarse meshes, measure them against finer ones, and take the cheapest that keeps the error.

    Whatever becomes of the runs there is an answer; after an interruption it is what is known by then.
    Raises RequestError for a scene without contact.
    """
    if not scene.contacts:
        raise RequestError("the scene has no contact to choose for", where=scene.name, allowed="[[contacts]]")
    scene, _ = first_that_fits(scene, registry)
    search = _Search(Trials(scene, wish, registry, said))
    yield from search.survey()
    tried = 0
    while tried < len(search.trials.all):  # trials may widen what is unknown
        tried = len(search.trials.all)
        yield from search.refine()
        yield from search.cheaper()
    yield from search.timings()
    return answer(search.trials)


class _Search:
    """The stages of a search, each bounded by a part of its CPU time."""

    def __init__(self, trials: Trials) -> None:
        self.trials, self.wish, self.scene, self.registry = trials, trials.wish, trials.scene, trials.registry
        self.limit = max(STUBBORN * self.wish.search, min(LEAST_LIMIT, 0.3 * self.wish.search))

    # --- coarse meshes -----------------------------------------------------------------------------

    def survey(self) -> Plan:
        """Level 1 of everything that could win, then level 2 of one run for each slave, element and integrator."""
        trials, sides = self.trials, exchangeable(self.scene.data)
        patterns = [(), sides] if sides else [()]
        algorithms = algorithms_for(self.scene, self.registry)
        ways = integrators_for(self.scene, self.registry)
        finished: list[Configuration] = []
        while ways and not finished:
            way = ways.pop(0)
            every = [Configuration(a, pattern, "", way) for pattern in patterns for a in algorithms]
            for each in every:  # the first that finishes tells the load steps of all
                finished = finished or (yield from self._coarse([each]))
        if not finished:  # one of those that were stopped may take all that is left
            yield from trials.longer()
            return
        trials.steps = yield from self._load_steps(finished[0])
        first = replace(finished[0], steps=trials.steps)
        finished = yield from self._coarse([replace(first, algorithm=algorithm) for algorithm in algorithms])
        elements = elements_for(self.scene, self.registry)
        kinds = [first]
        if smooth := trials.facetted():  # facets are deepest at this level
            curved = [replace(each, smooth=smooth) for each in finished]
            kinds += possible(curved, self.scene, self.registry)[:1]
        others = [replace(kind, exchanged=p, element=e) for kind in kinds for e in elements for p in patterns]
        others = yield from self._coarse([each for each in others if each != first])
        rest = [replace(each, algorithm=one.algorithm) for one in finished[1:] for each in others]
        if self._cheap(sum(trials.cost((each, 1)) for each in others) * len(finished[1:])):
            others += yield from self._coarse(rest)
        for way in ways:
            others += yield from self._other_integrator(finished, replace(first, integrator=way, steps=0))
        finished += others
        # one of each first: if time is short they tell more than algorithms that differ in nothing else
        dear = sorted(finished, key=lambda each: (each.algorithm == first.algorithm, -trials.cost((each, 1))))
        families = {(each.smooth, each.element or (*each.exchanged, each.integrator)): each for each in dear}
        yield from trials.run([(each, 2) for each in families.values()], REFINED, self._limit(2))
        single = [replace(first, exchanged=(n,)) for n in sides if len(sides) > 1]
        if self._cheap(trials.cost((first, 1)) * len(single)):
            finished += yield from self._coarse(single)
        yield from trials.run([(each, 2) for each in finished], SURVEY, self._limit(2))
        self._so_far()

    def _coarse(self, wanted: Sequence[Configuration]) -> Generator[Sequence[Any], Sequence[Any], list[Configuration]]:
        """Level 1 of these; those that finished."""
        wanted = possible(wanted, self.scene, self.registry)
        yield from self.trials.run([(each, 1) for each in wanted], SURVEY, self._limit(1))
        return [each for each in wanted if self.trials.ladder(each)]

    def _cheap(self, cost: float) -> bool:
        """Return whether less than half of the rest of the survey is enough for runs of this cost [CPU s]."""
        return cost < 0.5 * (SURVEY * self.wish.search - self.trials.spent)

    def _limit(self, level: int) -> float:
        """CPU time [s] that a run of the survey may take: a part of the search, and not far more than the others."""
        costs = [trial.cost for (_, n), trial in self.trials.all.items() if n == 1 and trial.finished]
        usual = max(min(costs, default=math.inf), EQUAL) * level ** GROWTH[1]
        return float(min(self.limit, FAR * usual))

    def _load_steps(self, first: Configuration) -> Generator[Sequence[Any], Sequence[Any], int]:
        """Load steps with which the answer keeps still if it depends on them and nobody named them; 0 leaves them."""
        trials = self.trials
        before = trials.all[first, 1]
        if not trials.is_static(first) or self.scene.integrator.get("steps") or not before.facts.get("matters"):
            return 0
        steps = int(before.facts["steps"])
        for _ in range(DOUBLINGS):
            finer = replace(first, steps=2 * steps)
            yield from self._coarse([finer])
            after = trials.ladder(finer).get(1)
            if after is None or not (trials.comparable(before) and trials.comparable(after)):
                break
            trials.doubt = change = trials.apart(before, after)  # of first order: as much is left in the finer one
            if 2.0 * change <= STEPS * self.wish.error:
                trials.doubt *= 2.0
                break
            before, steps = after, 2 * steps
        return steps if steps > int(trials.all[first, 1].facts["steps"]) else 0

    def _other_integrator(
        self, finished: Sequence[Configuration], other: Configuration
    ) -> Generator[Sequence[Any], Sequence[Any], list[Configuration]]:
        """Level 1 with another integrator; all algorithms with it if it is no dearer."""
        trials, first = self.trials, finished[0]
        cost = trials.cost((first, 1))
        yield from trials.run([(other, 1)], SURVEY, max(cost, EQUAL) if other.integrator else self.limit)
        made = trials.ladder(other).get(1)
        if made is None:
            return []
        before = trials.all[first, 1]
        if not other.integrator and trials.comparable(before) and trials.comparable(made):
            trials.doubt = max(trials.doubt, trials.apart(before, made))  # the scene's own has the last word
        if made.cost > cost:
            return []
        return (yield from self._coarse([replace(each, integrator=other.integrator, steps=0) for each in finished]))

    # --- fine meshes -------------------------------------------------------------------------------

    def refine(self) -> Plan:
        """Finer runs of two that seem to have the least error left for their cost, until they are exact enough."""
        trials = self.trials
        while not trials.stopped and trials.known is None:
            truth = trials.truth()
            exact = truth is not None and truth.uncertainty <= self.wish.error / CLEAR
            if exact and truth is not None and not truth.alone:
                return
            climbing = [each for each in trials.ladders() if self._next_level(trials.by_name(each.name), 0.0)]
            if exact and truth is not None:  # another one is to vouch for it
                climbing = [each for each in climbing if each.finest < truth.level]
            above = [each for each in trials.ladders() if each.finest > 2]
            if len(above) >= CLIMBERS:
                climbing = [each for each in climbing if each.finest > 2]
            useless = truth is None or truth.uncertainty >= self.wish.error  # no trial could keep it
            left = (TRIED if useless else REFINED) * self.wish.search - trials.spent
            known = [(each, trials.by_name(each.name)) for each in climbing]
            finer = {each.name: (own, self._next_level(own, left)) for each, own in known}
            climbing = [each for each in climbing if trials.expected(*finer[each.name]) <= left]
            wanted = [finer[one.name] for _, one in beside(ranked(climbing, trials.judged(), truth), 2)]
            while wanted and sum(trials.expected(*place) for place in wanted) > left:
                wanted.pop()
            if not wanted:
                return
            yield from trials.run(wanted, 1.0)
            self._so_far()

    def _next_level(self, configuration: Configuration, left: float) -> int:
        """The next finer level: twice the finest, or less if that takes most of the CPU time left [s]; 0 if none."""
        finest = max(self.trials.ladder(configuration))
        tried = {level for each, level in self.trials.all if each == configuration}
        finer = [level for level in FINER if finest < level <= 2 * finest and level not in tried]
        fitting = [level for level in finer if self.trials.expected(configuration, level) < 0.6 * left]
        return max(fitting, default=next(iter(finer), 0))

    # --- trials ------------------------------------------------------------------------------------

    def cheaper(self) -> Plan:
        """Whatever may keep the error for less than the cheapest that does, the cheapest first."""
        truth = self.trials.truth()
        while truth is not None and not self.trials.stopped:
            wanted = self._worth_trying(truth)
            yield from self.trials.run(wanted, TRIED)
            if not any(place in self.trials.all for place in wanted):
                return

    def _worth_trying(self, truth: Truth) -> list[Place]:
        """The two cheapest trials that may keep the error, of each configuration the coarsest."""
        trials = self.trials
        best = min((trials.cost(place) for place in trials.meeting(truth)), default=math.inf)
        luck = LUCK if math.isfinite(best) and trials.pressed() else 1.0
        target = self.wish.error - truth.uncertainty - trials.doubt
        found: list[tuple[float, Place]] = []
        for each in trials.configurations():
            errors = trials.errors(each)
            for level in LEVELS if errors and target > 0.0 else ():
                if (each, level) in trials.all or level > truth.level or luck * _hoped(errors, level) > target:
                    continue
                cost = self._cost(each, level)
                if cost < min(best, self.wish.budget) and best > EQUAL:
                    found.append((cost, (each, level)))
                break
        found.sort(key=lambda pair: pair[0])
        return [place for _, place in found[:2]]

    def _cost(self, configuration: Configuration, level: int) -> float:
        """CPU time [s] to expect of a level, by coarser ones or those on both sides of it."""
        known = self.trials.ladder(configuration)
        if level > max(known):
            return self.trials.expected(configuration, level)
        costs = np.log([max(trial.cost, 1e-3) for trial in known.values()])
        return float(np.exp(np.interp(np.log(level), np.log(list(known)), costs)))

    def timings(self) -> Plan:
        """Repeat the runs that may be the cheapest."""
        trials, truth = self.trials, self.trials.truth()
        met = sorted(trials.meeting(truth), key=trials.cost) if truth is not None else []
        best = [place for place in met if trials.cost(place) <= max(2.0 * trials.cost(met[0]), EQUAL)][:4]
        left = self.wish.search - trials.spent
        fitting = [place for place in best if 2.0 * REPEATS * trials.cost(place) * len(best) < left]
        if fitting and not trials.stopped:
            yield [trials.again(place, number) for place in fitting for number in range(1, REPEATS)]

    def _so_far(self) -> None:
        """Say what would be answered now."""
        found, trials = answer(self.trials), self.trials
        error = f", error {100.0 * found.error:.2g} %" if math.isfinite(found.error) else ""
        trials.said(
            f"so far: {found.name}, level {found.level}{error} in {found.cost_s:.2g} s ({found.verdict}); "
            f"{trials.spent:.3g} of {self.wish.search:g} CPU s used"
        )


def _hoped(errors: dict[int, float], level: int) -> float:
    """The error that a level may have at best, by those of others."""
    levels = sorted(errors)
    last = levels[-1]
    if level < last:
        coarser = [n for n in levels if n < level]
        finer = min(n for n in levels if n > level)
        if not coarser:
            return errors[finer]
        share = math.log(level / coarser[-1]) / math.log(finer / coarser[-1])
        return 0.85 * float(errors[coarser[-1]] ** (1.0 - share) * errors[finer] ** share)
    order = BEST_ORDER
    if len(levels) > 1:
        fall = math.log(errors[levels[-2]] / max(errors[last], 1e-12)) / math.log(last / levels[-2])
        order = min(max(1.2 * fall, 0.5), 2.0)
    return float(errors[last] * (last / level) ** order)
