"""`contactlab choose`: the cheapest way to run a scene to an error."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import Any

from contactlab.accuracy.choose import Chosen, Wish, choose
from contactlab.accuracy.point import Point
from contactlab.commands.common import add_row, console, fitting, parse_settings, print_json, registry_with, table
from contactlab.commands.interruption import interrupted
from contactlab.parts.machine import usable_cores
from contactlab.run.folders import results_folder
from contactlab.scene.scene import load_scene
from contactlab.studies.resume import sigterm_as_ctrl_c

CANNOT = 1


def choose_for(options: argparse.Namespace) -> int:
    """Search, say what was found and what it will cost, and run it where that is asked for; 1 where nothing does."""
    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry).with_(parse_settings(options.settings))
    wish = Wish(options.error, options.budget, options.search)
    with results_folder(options.out, f"choose-{scene.name}", options.resume) as folder:
        try:
            with sigterm_as_ctrl_c():
                found = choose(scene, wish, registry, folder, options.jobs or usable_cores(), _tell, _say)
        except KeyboardInterrupt:
            return interrupted(folder)
    line = command(options, found)
    if options.json:
        print_json({"folder": str(folder), "command": line, "known": found.known, **vars(found)})
    else:
        show(found, wish, line, folder)
    if not found.settings:
        return CANNOT
    return _run(options, found, folder) if options.run else 0


def show(found: Chosen, wish: Wish, line: str, folder: Path) -> None:
    """The choice first, then what was tried."""
    out = console()

    def say(text: str) -> None:
        out.print(text, markup=False, highlight=False, soft_wrap=True)

    if found.settings:
        cost, low, high = found.cost
        say(f"{found.name}, level {found.level}: {100.0 * found.error:.2g} % in {cost:.2g} CPU s "
            f"({low:.2g} to {high:.2g}): {found.why}")  # fmt: skip
        say(line)
    else:
        say(f"cannot reach {100.0 * wish.error:g} % in {wish.budget:g} CPU s: {found.why}")
    known = f", {found.known} of them known to the archive" if found.known else ""
    spent = sum(point.spent for point in found.tried)
    say(f"{len(found.tried)} trials{known}, {spent:.3g} CPU s; reference: {found.reference or 'none'}, known to "
        f"{100.0 * found.uncertainty:.2g} %; {folder}")  # fmt: skip
    shown = table("configuration", "slave", "level", "error, %", "CPU s", "")
    for p in sorted(found.tried, key=lambda p: (p.contender, p.slave, p.level)):
        error = f"{100.0 * p.error:.3g}" if p.finished else ""
        end = "" if p.finished else f"{p.status}: {p.reason[:60]}"
        add_row(shown, p.contender, p.slave, str(p.level), error, f"{p.cost:.3g}" if p.cpu else "", end)
    if found.tried:
        out.print(fitting(shown, out.width, last=("configuration",)))


def command(options: argparse.Namespace, found: Chosen) -> str:
    """The command that makes the chosen run."""
    settings = [*options.settings, *(f"{key}={_written(value)}" for key, value in found.settings.items())]
    words = [word for setting in settings for word in ("--set", setting)]
    words += [word for file in options.files for word in ("--with", file)]
    return shlex.join(["contactlab", "run", options.scene, *words]) if found.settings else ""


def _written(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _run(options: argparse.Namespace, found: Chosen, folder: Path) -> int:
    from contactlab.commands.run import run

    settings = [*options.settings, *(f"{key}={_written(value)}" for key, value in found.settings.items())]
    return run(
        argparse.Namespace(
            scene=options.scene, settings=settings, files=options.files, out=str(folder / "run"), resume=False,
            json=options.json,
        )
    )  # fmt: skip


def _say(line: str) -> None:
    print(f"reference: {line}", file=sys.stderr, flush=True)


def _tell(point: Point, done: int, total: int) -> None:
    end = f"{100.0 * point.error:.3g} % in {point.cost:.3g} s" if point.finished else f"{point.status}: {point.reason}"
    print(f"{point.contender}, {point.slave}, level {point.level}: {end}", file=sys.stderr, flush=True)
