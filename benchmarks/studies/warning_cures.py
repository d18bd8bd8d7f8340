"""Alarms judged by their own claim: whether a run reports something else once what its warning advises is done.

The line that a warning advises to write goes into the scenes of the runs that gave it; where it advises finer cells
alone, their level is doubled. The alarm is right if a number that a run reports changes by more than this:

    forces, reactions            1 % of the largest of the run, at their peak and at the end
    energies                     2 % of the largest one, at the end: 1 % in displacements and velocities
    pressure and shear           5 %, at the end: L2 of the difference over nodes, of unlike meshes the largest value
    friction and plastic work    5 %, of what is 1 % of the largest energy or more
"""

from __future__ import annotations

import re
import tomllib
from collections import defaultdict
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Job, Record
from contactlab.cases.run_case import case_plan
from contactlab.jobs.run import Run
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene
from contactlab.verdicts.plan import Cell

FORCE, ENERGY, PRESSURE, WORK = 0.01, 0.02, 0.05, 0.05
COUNTS = 0.01  # of the largest energy, or of the largest pressure: works and shears that are less are not compared
LINE = re.compile(r'\b(?:write|set|take) ([\w.-]+) = ("[^"]*"|true|false|[\d.e+-]*\d)')
FINER = re.compile(r"half as long|finer|\(level\)|as short")

Changes = dict[str, Any]


def cure(warning: Mapping[str, Any], level: int) -> Changes:
    """What to change in a scene as a warning of it advises; nothing where it names neither line nor finer cells."""
    key, text = str(warning["key"]), str(warning["text"]).partition(";")[2]
    if found := LINE.search(text):
        name, value = found[1], tomllib.loads(f"value = {found[2]}")["value"]
        return {key if key.endswith(f".{name}") else name: value}
    return {"level": 2 * level} if FINER.search(text) else {}


def cured_plan(
    cell: Cell, codes: Sequence[str] = ()
) -> Generator[Sequence[Run], Sequence[Record], dict[str, str | None]]:
    """By each code that the runs of a cell give, or of `codes`: which number its cure changes, "" for none.

    None where nothing can be said: a run did not come to its end.
    """
    asked: list[tuple[Job, Scene]] = []

    def keep(job: Job, scene: Scene) -> Run:
        asked.append((job, scene))
        return Run(job, scene, f"{cell.name} {job.name}")

    registry = default_registry()
    _, done = yield from case_plan(cell.case(registry), cell.setup, registry, keep)
    told = defaultdict[str, list[tuple[Record, Run]]](list)
    for (job, scene), before in zip(asked, done.values(), strict=False):
        changes = defaultdict[str, Changes](dict)
        for warning in before.summary.get("warnings", ()):
            if not codes or warning["code"] in codes:
                changes[warning["code"]] |= cure(warning, scene.level)
        for code, values in changes.items():
            if values:
                changed = replace(job, changes={**job.changes, **values})
                told[code].append((before, Run(changed, scene.with_(values), f"{cell.name} {job.name} {code}")))
    after = yield [run for pairs in told.values() for _, run in pairs]
    records = iter(after)
    return {code: _judged([(before, next(records)) for before, _ in pairs]) for code, pairs in told.items()}


def _judged(pairs: list[tuple[Record, Record]]) -> str | None:
    compared = [difference(before, after) for before, after in pairs if before.finished and after.finished]
    return next((name for name in compared if name), "") if compared else None


def difference(before: Record, after: Record) -> str:
    """The first reported number by which two runs differ, with its change; empty where they agree."""
    for name, first, second, limit, scale in _numbers(before, after):
        change = float(np.linalg.norm(np.asarray(second) - np.asarray(first))) / max(scale, 1e-300)
        if change > limit:
            return f"{name} {change:.1%}"
    return ""


def _numbers(before: Record, after: Record) -> Iterator[tuple[str, Any, Any, float, float]]:
    """Name, both values, allowed change, and the scale of it, of what both runs report."""
    one, two = before.summary, after.summary
    forces = {**one["peaks"]["reactions"], **{k: v["force"] for k, v in one["peaks"]["contacts"].items()}}
    others = {**two["peaks"]["reactions"], **{k: v["force"] for k, v in two["peaks"]["contacts"].items()}}
    largest = max((value["value"] for value in forces.values()), default=0.0)
    for name in forces.keys() & others.keys():
        yield f"peak of {name}", forces[name]["value"], others[name]["value"], FORCE, largest
    for name in one["reactions"].keys() & two["reactions"].keys():
        yield name, one["reactions"][name], two["reactions"][name], FORCE, largest
    for name in one["contacts"].keys() & two["contacts"].keys():
        # exchanged sides: the force on the other one
        first, second = (np.array(data["contacts"][name]["resultant"], float) for data in (one, two))
        yield name, first, second if first @ second >= 0.0 else -second, FORCE, largest
    most = max(abs(one["balance"][name]) for name in ("kinetic", "stored", "plastic", "friction", "external"))
    for name in ("kinetic", "stored"):
        yield name, one["balance"][name], two["balance"][name], ENERGY, most
    for name in ("friction", "plastic"):
        work = one["balance"][name]
        if abs(work) > COUNTS * most:
            yield f"{name} work", work, two["balance"][name], WORK, abs(work)
    for name in before.curves.keys() & after.curves.keys():
        curves = before.curve(name), after.curve(name)
        alike = _same_nodes(*curves)
        least = COUNTS * float(np.abs(curves[0].nodal_pressure).max(initial=0.0))
        for column in ("nodal_pressure", "shear"):
            values = [np.abs(getattr(curve, column)) for curve in curves]
            if not alike:
                values = [value.max(initial=0.0) for value in values]
            if np.max(values[0], initial=0.0) > least:
                yield f"{column} of {name}", *values, PRESSURE, float(np.linalg.norm(values[0]))


def _same_nodes(first: ContactCurve, second: ContactCurve) -> bool:
    """Whether two curves have the same nodes, less than a segment apart: sides that are exchanged run the other way."""
    ends = [np.stack([curve.x, curve.y]) for curve in (first, second)]
    if ends[0].shape != ends[1].shape:
        return False
    return bool(np.hypot(*(ends[1] - ends[0])).max() < np.hypot(*np.diff(ends[0], axis=1)).max())
