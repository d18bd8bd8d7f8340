"""`contactlab choose`: the cheapest way to run a scene to an error."""

from __future__ import annotations

import argparse
import math
import shlex
from collections.abc import Sequence
from pathlib import Path

from contactlab.accuracy.answer import Tried
from contactlab.accuracy.choose import Chosen, Wish, choose_plan
from contactlab.commands.common import console, json_text, parse_settings, print_json, registry_with, typed, written
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.reports.sheet import Column, Sheet
from contactlab.scene.scene import load_scene

FILE = "choose.json"
CANNOT = 1
MOST = 12
"""Trials that are listed."""


def choose(options: argparse.Namespace) -> int:
    """Search, say what was found and what it will cost, and run it if asked; 1 if nothing keeps the error.

    After Ctrl-C the answer is what is known by then.
    """
    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry, parse_settings(options.settings))
    wish = Wish(options.error, options.budget, options.search)
    with many(options, f"choose-{scene.name}") as driver:
        folder = folder_of(driver)
        found = driver.result(choose_plan(scene, wish, registry, driver.progress.told))
        stopped = driver.interrupted
    line = command(options, found)
    data = {key: value for key, value in vars(found).items() if key != "configuration"} | {"command": line}
    if not stopped:
        (folder / FILE).write_text(json_text({"format": 1, **data}), encoding="utf-8")
    if options.json:
        print_json({**data, "folder": str(folder)})
    else:
        show(found, wish, line)
    if stopped:
        return interrupted(options, folder)
    if found.verdict != "ok":
        return CANNOT
    return _run(options, found, folder / "run") if options.run else 0


def show(found: Chosen, wish: Wish, line: str) -> None:
    """The choice first, then what was tried."""
    out = console()
    say = out.say
    error = "error unknown" if math.isnan(found.error) else f"error {100.0 * found.error:.2g} %"
    if found.error_interval is not None:
        error += f" ({100.0 * found.error_interval[0]:.2g} to {100.0 * found.error_interval[1]:.2g} %)"
    cost = "" if math.isnan(found.cost_s) else f" in {found.cost_s:.2g} CPU s"
    if found.verdict != "ok":
        say(f"cannot promise {100.0 * wish.error:g} %")
    say(f"{found.name}, level {found.level}: {error}{cost}: {found.why}")
    say(line)
    known = f", uncertainty {100.0 * found.uncertainty:.2g} %" if math.isfinite(found.uncertainty) else ""
    trials = "1 trial" if len(found.tried) == 1 else f"{len(found.tried)} trials"
    compared = f"; compared by {found.judged} with {found.reference}{known}" if found.judged and found.reference else ""
    say(f"{trials}, {found.spent_s:.3g} CPU s{compared}")
    if found.tried:
        heads = Column("configuration", keep=True), "level", Column("error", "%"), Column("CPU", "s"), ""
        out.print(Sheet(heads, map(_tried, best_first(found.tried, wish.error)[:MOST])))
    if found.verdict == "ok" and any(one.error <= wish.error and _median(one) < found.cost_s for one in found.tried):
        say("cheaper trials: their error, with all that is uncertain, may exceed the target")
    if len(found.tried) > MOST:
        say(f"and {len(found.tried) - MOST} others, farther from the error or slower: --json, {FILE}")


def best_first(tried: Sequence[Tried], error: float) -> list[Tried]:
    """Trials with the error first, the cheapest before others; then the most accurate; then those without an error."""

    def rank(one: Tried) -> tuple[bool, bool, float]:
        near = one.error <= error
        return not near, math.isnan(one.error), _median(one) if near else one.error

    return sorted(tried, key=rank)


def _median(tried: Tried) -> float:
    """CPU time [s] of a trial; NaN if no run of it ended."""
    return sorted(tried.cpu_s)[len(tried.cpu_s) // 2] if tried.cpu_s else math.nan


def _tried(tried: Tried) -> list[str]:
    error = f"{100.0 * tried.error:.3g}" if math.isfinite(tried.error) else ""
    cost = f"{_median(tried):.3g}" if tried.cpu_s else ""
    end = "" if tried.status == "finished" else f"{tried.status}: {tried.reason[:60]}"
    return [tried.configuration, str(tried.level), error, cost, end]


def command(options: argparse.Namespace, found: Chosen) -> str:
    """The command that makes the chosen run."""
    return typed("run", argparse.Namespace(**vars(options) | {"settings": _settings(options, found)}))


def _settings(options: argparse.Namespace, found: Chosen) -> list[str]:
    return [*options.settings, *(f"{key}={written(value)}" for key, value in found.choice.items())]


def _run(options: argparse.Namespace, found: Chosen, out: Path) -> int:
    from contactlab.commands.arguments import make_parser
    from contactlab.commands.run import run

    words = [*shlex.split(command(options, found))[1:], "--out", str(out)]
    words += ["--json"] * options.json + ["--resume"] * (options.resume and out.exists())
    return run(make_parser().read(words))
