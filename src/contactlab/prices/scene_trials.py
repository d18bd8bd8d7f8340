"""Trials of a scene and of its variants: runs of some seconds, for what nobody can count before (sweeps, iterations).

A run that is foreseen to be longer is cut; what was done of it tells how far foreseen costs are off.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from datetime import date
from statistics import median_low
from typing import NamedTuple

from contactlab.errors import RequestError, one_line
from contactlab.prices.kept_trials import SceneTrial, trial_key
from contactlab.prices.lacking import lacking
from contactlab.prices.measure import ENDED_AS
from contactlab.prices.price import price_of
from contactlab.prices.price_list import PriceList
from contactlab.prices.quiet import Quiet, Timed
from contactlab.scene.scene import Scene
from contactlab.studies.removable import variants

LIMIT = 5.0  # s of CPU time, as foreseen, after which a run is cut
SHORT, TIMES = 1.0, 3  # a run of less CPU time [s] is made so many times, and that of median cost counts

Progress = Callable[[str, float], None]


class ToTry(NamedTuple):
    """A scene or a variant of it, and what to call it."""

    name: str
    scene: Scene


def to_try(scene: Scene) -> Iterator[ToTry]:
    """The scene and all variants that `contactlab explain` tells the price of; not those that are refused."""
    yield ToTry(scene.name, scene)
    for variant in (*variants(scene), *lacking(scene)):
        try:
            yield ToTry(f"{scene.name} {variant.label}", scene.with_(variant.changes))
        except RequestError:
            continue


def make_trials(
    scenes: Sequence[Scene], prices: PriceList, progress: Progress | None = None
) -> Iterator[tuple[str, SceneTrial]]:
    """Trials of scenes and of their variants, each with its key."""
    if not scenes:
        return
    quiet = Quiet(scenes[0].registry)
    for number, scene in enumerate(scenes):
        found = list(to_try(scene))
        _tried(found[0], prices, quiet)  # imports and kernels, which runs that follow have
        for at, one in enumerate(found):
            if progress is not None:
                progress(one.name, (number + at / len(found)) / len(scenes))
            yield trial_key(one.scene), _tried(one, prices, quiet)


def _tried(one: ToTry, prices: PriceList, quiet: Quiet) -> SceneTrial:
    today = date.today().isoformat()
    try:
        work = work_within(LIMIT, one.scene, prices)
        made = [quiet.timed(one.scene, tries=1, work=work)]
        while made[0].run.cpu_s < SHORT and len(made) < TIMES:
            made.append(quiet.timed(one.scene, tries=1, work=work))
    except RequestError as error:
        return SceneTrial(one.name, today, ended=one_line(error, name=False).removeprefix(ENDED_AS))
    run = _middle(made).run
    return SceneTrial(one.name, today, *run.length, run.cpu_s, run.arrays_mib, run.ended, run.done)


def _middle(made: Sequence[Timed]) -> Timed:
    """The run of median cost."""
    middle = median_low([one.run.cpu_s for one in made])
    return next(one for one in made if one.run.cpu_s == middle)


def work_within(limit: float, scene: Scene, prices: PriceList) -> float:
    """Steps and iterations that are foreseen to take so much CPU time [s]; no fewer than those of a step."""
    whole = price_of(scene, prices)
    if not whole.cpu_s > 0.0:
        return math.inf
    return max(1.0, limit * whole.work / whole.cpu_s)
