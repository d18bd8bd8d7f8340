"""Is what `contactlab choose` chooses good? Against a finer solution and all other configurations of each scene.

    python benchmarks/studies/choices.py [--only WORD,WORD] [--search S]

For each scene of choice_scenes.py the search is run as the command does it. Then every algorithm, with contacts as
declared or exchanged, with q1, q1-fbar and q2 and by every integrator that applies, is run at LEVELS, up to the cost of
the chosen one, or DEAREST times that if it was not promised to keep the error. All are measured against the finest runs
of a longer search, or the installed reference; smooth surfaces take part if runs report coarse facets. One line a
scene: the error of the choice, whether its promise is kept, and its cost over that of the cheapest run that meets the
error. A promise is not judged if what it is measured against is known worse than the error asked for. The last line
counts the verdicts.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import choice_scenes
from choice_scenes import Asked

from contactlab.accuracy.choose import Chosen, Wish, choose_plan
from contactlab.accuracy.configuration import (
    Configuration,
    algorithms_for,
    elements_for,
    exchangeable,
    integrators_for,
    possible,
)
from contactlab.accuracy.trials import EQUAL, Place, Plan, Trials
from contactlab.jobs.driver import Driver
from contactlab.parts.registry import default_registry

LEVELS = (1, 2, 3, 4)
LONGER = 3.0
"""Times the search that finding the finer solution may take."""
DEAREST = 4.0


def promise(found: Chosen, error: float, known: float, asked: float) -> str:
    """Whether an error, known to +- `known`, is the one that was promised: kept, WRONG, none or not judged."""
    if found.verdict != "ok":
        return "none"
    return "not judged" if not known < asked else "kept" if error <= asked else "WRONG"


def measure(asked: Asked, search: float, folder: Path) -> tuple[str, str]:
    """The verdict and the line of a scene."""
    registry, wish = default_registry(), Wish(asked.error, search=search)
    with Driver(folder) as driver:
        found: Chosen = driver.result(choose_plan(asked.scene, wish, registry))
        judge = Trials(asked.scene, replace(wish, error=0.1 * asked.error, search=LONGER * search), registry)
        driver.result(_all(judge, found))
    if found.verdict != "ok":
        print(f"{asked.scene.name}: {found.why}", flush=True)
    places = [place for place in judge.all if not math.isnan(judge.error(place))]
    met = [judge.cost(place) for place in places if judge.error(place) <= asked.error]
    error, truth = judge.error((found.configuration, found.level)), judge.truth()
    ratio = max(found.cost_s, EQUAL) / max(min(met, default=math.nan), EQUAL)
    known = truth.uncertainty if truth else math.nan
    kept = promise(found, error, known, asked.error)
    of_truth = f"the finer solution is known to {100 * known:.2g} %"
    judged = f"not judged: {of_truth}" if kept == "not judged" else f"is {100 * error:.2g} % ({of_truth}): {kept}"
    best = min((place for place in places if judge.error(place) <= asked.error), key=judge.cost, default=None)
    cheapest = f" ({judge.name(best[0])}, level {best[1]}, {judge.cost(best):.2g} s)" if best else ""
    line = (
        f"{asked.scene.name}: {found.verdict}, {found.name}, level {found.level}; asked {100 * asked.error:g} %, said "
        f"{100 * found.error:.2g} %, {judged}; "
        f"{found.cost_s:.2g} s, {ratio:.2g} of the best{cheapest}; {found.spent_s:.3g} CPU s searched"
    )
    return kept, line


def _all(judge: Trials, found: Chosen) -> Plan:
    """The chosen run, finer runs like it, with half its load steps, and all others that are not much dearer."""
    scene, registry, chosen = judge.scene, judge.registry, found.configuration
    sides = exchangeable(scene.data)

    def can(wanted: Iterable[Configuration]) -> list[Configuration]:
        return possible(wanted, scene, registry)

    every = can(
        Configuration(algorithm, pattern, element, way)
        for algorithm in registry.names("contact")
        for pattern in ([(), sides] if sides else [()])
        for element in elements_for(scene, registry)
        for way in integrators_for(scene, registry)
    )
    if chosen.steps:
        every += [replace(each, steps=chosen.steps) for each in every if judge.is_static(each)]
        judge.steps = 2 * chosen.steps
    names = [chosen.algorithm, *algorithms_for(scene, registry)]
    exact = next(name for name in names if name in judge.exact)  # the others are no reference
    alike = replace(chosen, algorithm=exact, steps=2 * chosen.steps)
    kinds = [replace(alike, element=e, smooth=s) for e in {chosen.element, "", "q2"} for s in {chosen.smooth, None}]
    fine: list[Place] = [(each, n) for each in can(kinds) for n in (4, 8, 16)]
    yield from judge.run([(chosen, found.level)], 1.0)
    if judge.known is None:
        yield from judge.run(fine, 0.6)
    limit = (1.0 if found.verdict == "ok" else DEAREST) * max(found.cost_s, EQUAL)
    yield from judge.run([(each, 1) for each in every], 1.0, limit)
    if smooth := chosen.smooth or judge.facetted():
        every += can([replace(each, smooth=smooth) for each in every])
    for level in LEVELS:
        cheap = [each for each in every if judge.expected(each, level) <= limit]
        yield from judge.run([(each, level) for each in cheap], 1.0, limit)


def main() -> None:
    """Judge the choices of all scenes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="")
    parser.add_argument("--search", type=float, default=120.0)
    options = parser.parse_args()
    verdicts = Counter[str]()
    for asked in choice_scenes.asked():
        if any(word in asked.scene.name for word in options.only.split(",")):
            with TemporaryDirectory() as folder:
                verdict, line = measure(asked, options.search, Path(folder))
            verdicts[verdict] += 1
            print(line, flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in verdicts.items()))


if __name__ == "__main__":
    main()
