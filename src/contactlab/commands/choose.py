"""`contactlab choose`: the cheapest way to run a scene to an error."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import Any

from contactlab.accuracy.choose import Chosen, Wish, choose_plan
from contactlab.accuracy.run import point_text
from contactlab.commands.common import add_row, console, fitting, parse_settings, print_json, registry_with, table
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.scene.scene import load_scene

CANNOT = 1


def choose_for(options: argparse.Namespace) -> int:
    """Search, say what was found and what it will cost, and run it where that is asked for; 1 where nothing does."""
    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry).with_(parse_settings(options.settings))
    wish = Wish(options.error, options.budget, options.search)
    with many(options, f"choose-{scene.name}") as driver:
        folder, say = folder_of(driver), driver.progress.told
        found = driver.result(choose_plan(scene, wish, registry, folder, lambda point: say(point_text(point)), say))
        if driver.interrupted:
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
