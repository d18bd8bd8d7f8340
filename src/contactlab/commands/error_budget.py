"""`contactlab error-budget`: where the error of a run sits, and what to refine next."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from contactlab.accuracy.error_budget import UNRESOLVED, ErrorBudget, Share, budget_plan
from contactlab.commands.common import console, parse_settings, print_json, registry_with, written
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.jobs.rows import finite
from contactlab.reports.numbers import percent, significant
from contactlab.reports.sheet import Column, Sheet
from contactlab.scene.scene import load_scene

FILE = "error-budget.json"
FAILED = 1


def error_budget(options: argparse.Namespace) -> int:
    """Run the scene as it is and with each choice of numerics made finer; 1 if it does not finish as it is."""
    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry, parse_settings(options.settings))
    with many(options, f"error-budget-{scene.name}") as driver:
        folder = folder_of(driver)
        found = driver.result(budget_plan(scene, registry, driver.progress.told))
        if driver.interrupted:
            return interrupted(options, folder)
    shares = [asdict(share) | {"gain": share.gain, "resolved": share.resolved} for share in found.shares]
    best = found.cheapest
    data = {"format": 1, "status": found.status, "reason": found.reason, "cost": found.cost, "shares": shares,
            "next": best.knob.name if best is not None else None}  # fmt: skip
    data = finite(data)
    (folder / FILE).write_text(json.dumps(data, indent=1), encoding="utf-8")
    if options.json:
        print_json({"folder": str(folder), **data})
    else:
        show(found, folder)
    return FAILED if not found.shares else 0


def show(found: ErrorBudget, folder: Path) -> None:
    """A row for each choice, the largest part of the error first, and what to refine next."""
    out = console()
    say = out.say
    if not found.shares:
        say(f"the run of the unchanged scene ended {found.status}: {found.reason}")
        return
    heads = [Column("made finer", keep=True), Column("pressure", "%", keep=True), Column("force", "%")]
    out.print(Sheet([*heads, Column("CPU", "s"), Column("more", "s"), "how"], map(_row, found.shares)))
    for share in found.shares:
        if remark := _remark(share):
            say(f"{share.knob.name}: {remark}")
    say(
        f"parts of the error of the unchanged scene ({significant(found.cost, 2)} CPU s), by refining each choice; "
        "mesh and elements: the same error twice; slaves: the difference, either may be right"
    )
    best = found.cheapest
    if best is not None:
        more = f"{significant(best.extra, 2)} CPU s more" if best.extra > 0.0 else "no more time"
        what = "forces" if math.isnan(best.pressure) else "pressure"
        part = f"{percent(best.part)} % of the {what}" if best.resolved else "not resolved yet"
        say(f"next: {best.knob.name}, {part}, for {more}")
    say(str(folder))


def _row(share: Share) -> list[str]:
    settings = ", ".join(f"{key}={written(value, digits=6)}" for key, value in _gathered(_changed(share)))
    costs = significant(share.cost, 2), significant(share.extra, 2)
    return [share.knob.name, _part(share.pressure), _part(share.force), *costs, settings]


def _remark(share: Share) -> str:
    """Why the numbers of a row are none, or say little."""
    if not share.resolved:
        return f"not resolved: no estimate from changes above {percent(UNRESOLVED)} %"
    if share.away:
        return "does not help: no closer to the finer mesh"
    return "" if share.status == "finished" else f"{share.status}: {share.reason}"


def _gathered(changed: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Keys that differ in one name and have the same value as one: bodies.{disc,block}.element."""
    groups: dict[tuple[str, str, Any], list[str]] = {}
    for key, value in changed:
        first, _, rest = key.partition(".")
        name, _, last = rest.rpartition(".")
        groups.setdefault((first, last, value) if name else (key, "", value), []).append(name)
    return [
        (f"{first}.{names[0] if len(names) == 1 else '{' + ','.join(names) + '}'}.{last}" if last else first, value)
        for (first, last, value), names in groups.items()
    ]


def _part(value: float) -> str:
    """In per cent if it is resolved."""
    return f"> {percent(UNRESOLVED)}" if value >= UNRESOLVED else percent(value)


def _changed(share: Share) -> list[tuple[str, Any]]:
    """The key that makes it finer: the key of a ramp or of damping, if others are written out with it."""
    settings = dict(share.knob.settings)
    wanted = f"time.{share.knob.name}"
    return [(wanted, settings[wanted])] if wanted in settings else list(settings.items())
