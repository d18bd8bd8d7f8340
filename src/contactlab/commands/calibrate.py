"""`contactlab calibrate`: the prices of this machine, from which `contactlab explain` foresees what runs will cost.

With scenes it makes trials of them as well, and keeps prices that are there already.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from contactlab.commands.common import add_row, console, number, parse_settings, print_json, registry_with, table
from contactlab.errors import RequestError

if TYPE_CHECKING:
    from contactlab.parts.registry import Registry
    from contactlab.prices.calibrate import Progress
    from contactlab.prices.kept_trials import SceneTrial
    from contactlab.prices.price_list import PriceList
    from contactlab.scene.scene import Scene

ALL = "all"


def calibrate(options: argparse.Namespace) -> int:
    """Measure the prices of all parts and keep them, in place of those that were there; or make trials of scenes."""
    registry = registry_with(options.files)
    if options.scenes:
        return _calibrate_scenes(options, registry)
    if options.settings:
        raise RequestError("there is no scene for --set to change", hint="contactlab calibrate SCENE --set KEY=VALUE")
    replaced = _replaced()
    prices, file = _measured(registry, options.rounds)
    if options.json:
        print_json({"format": 1, "file": file, "replaced": replaced, **_plain(prices)})
        return 0
    out = console()
    out.print(_table(prices))
    for part, reason in prices.unknown.items():
        out.print(f"no price of {part}: {reason}", markup=False, highlight=False, soft_wrap=True)
    _print_end(replaced, file)
    return 0


def _measured(registry: Registry, rounds: int) -> tuple[PriceList, str]:
    """The prices of this machine, measured and kept; the file."""
    from contactlab.prices.calibrate import calibrate as prices_of
    from contactlab.prices.price_list import store_prices

    with _told("measuring prices") as progress:
        prices = prices_of(registry, rounds, progress)
    return prices, str(store_prices(prices))


def _calibrate_scenes(options: argparse.Namespace, registry: Registry) -> int:
    """Make trials of scenes, keep them beside those of other scenes, and print them."""
    from contactlab.prices.kept_trials import BrokenTrialsError, load_trials, store_trials, trial_file
    from contactlab.prices.price_list import NoPricesError, load_prices
    from contactlab.prices.scene_trials import make_trials

    scenes = [scene.with_(parse_settings(options.settings)) for scene in _scenes(options.scenes, registry)]
    trials: dict[str, SceneTrial] = {}
    replaced = ""
    try:
        trials.update(load_trials())
    except BrokenTrialsError as error:
        replaced = f"made anew: {error}"
    try:
        prices = load_prices()
    except NoPricesError:
        prices, _ = _measured(registry, options.rounds)
    made: dict[str, SceneTrial] = {}
    with _told("making trials") as progress:
        for key, trial in make_trials(scenes, prices, progress):
            made[key] = trials[key] = trial
            store_trials(trials)  # each at once: what is there is of use if this is stopped
    file = str(trial_file())
    if options.json:
        print_json({"format": 1, "file": file, "replaced": replaced, "trials": list(made.values())})
        return 0
    console().print(_trial_table(list(made.values())))
    _print_end(replaced, file)
    return 0


def _scenes(names: Sequence[str], registry: Registry) -> list[Scene]:
    """The scenes that are named; all that come with the core for the word `all`."""
    from contactlab.parts.scenes_and_commands import core_scenes
    from contactlab.scene.scene import load_scene

    words = [one for name in names for one in (core_scenes() if name == ALL else [name])]
    return [load_scene(word, registry) for word in dict.fromkeys(words)]


def _print_end(replaced: str, file: str) -> None:
    out = console()
    if replaced:
        out.print(replaced, markup=False, highlight=False, soft_wrap=True)
    out.print(f"kept in {file}", markup=False, highlight=False, soft_wrap=True)


def _replaced() -> str:
    """What is said of a file that was there and is of no use; nothing where none was."""
    from contactlab.prices.price_list import load_prices, price_file

    try:
        load_prices()
    except RequestError as error:
        return f"made anew: {error}" if price_file().exists() else ""
    return ""


def _plain(prices: PriceList) -> dict[str, object]:
    return {name: getattr(prices, name) for name in prices.__dataclass_fields__ if name != "format"}


def _table(prices: PriceList) -> object:
    """A row for each unit: its price in microseconds."""
    shown = table("of", "each", "CPU µs", title=f"prices of {prices.machine}, {prices.made}")
    for unit, price in prices.units.items():
        part, _, what = unit.partition(": ")
        add_row(shown, part, what, f"{1e6 * price:.3g}" if price else "in others")
    return shown


def _trial_table(trials: Sequence[SceneTrial]) -> object:
    """A row for each trial: what was made of the run, and what it took."""
    shown = table("trial of", "steps", "iterations", "CPU s", "ended")
    for one in trials:
        ended = {"": "at its end", "cut": f"cut at {100.0 * one.done:.0f} %"}.get(one.ended, one.ended)
        made = ("", "", "") if one.failed else (number(one.steps), number(one.iterations), f"{one.cpu_s:.3g}")
        add_row(shown, one.scene, *made, ended)
    return shown


@contextmanager
def _told(doing: str) -> Iterator[Progress | None]:
    """A line on the terminal that says what is measured; nothing where there is none."""
    if not sys.stderr.isatty():
        yield None
        return

    from contactlab.reports.terminal import Terminal

    with Terminal(stderr=True).status(doing) as line:
        yield lambda part, share: line.update(f"{doing}: {100.0 * share:.0f} %, {part}")
