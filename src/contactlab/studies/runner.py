"""A comparison: the plan of all combinations of a study, and the table of what came out."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from contactlab.api import Record
from contactlab.errors import RequestError
from contactlab.jobs.driver import Driver
from contactlab.jobs.system import machine
from contactlab.parts.registry import Registry
from contactlab.results.result_file import FILE
from contactlab.run.folders import full_disk_told
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import write_toml
from contactlab.studies.combination import combination_plan
from contactlab.studies.cost_breakdown import BreakdownPlan, breakdown_of, plan_breakdown
from contactlab.studies.find_reference import Source, find_reference
from contactlab.studies.finest import finest_plan
from contactlab.studies.gather import common_reference, gather, row_of
from contactlab.studies.installed_measures import measure_columns
from contactlab.studies.plan import Combination, Plan, Vary, make_plan
from contactlab.studies.recordings import RUNS, record_comparison, side_by_side
from contactlab.studies.study import FINEST, Study, check_repeat
from contactlab.studies.table import Row, Table
from contactlab.studies.table_files import write_table

RECORDER, SUMMARY = "vtkhdf", "summary.json"
Records = dict[str, Record]
Keep = Callable[[Row, Scene, str], None]
"""Function called with a row, its scene and the name of the machine that made it."""


def planned(
    request: Scene | Study | str | Path, vary: Vary | None = None, registry: Registry | None = None,
    changes: Mapping[str, Any] | None = None, effects: bool = False, time_limit: float | None = None,
    repeat: int | None = None, reference: str | None = None,
) -> Plan:  # fmt: skip
    """The combinations of a request, with what replaces the study's own. Raises RequestError."""
    check_repeat(repeat, "repeat")
    if time_limit is not None and not 0.0 < time_limit < math.inf:
        raise RequestError("no time to run in", where="time_limit", got=time_limit, allowed="seconds, above 0")
    if effects and vary:
        raise RequestError(
            "effects are taken out of one scene, and no keys are varied", where="vary", got=", ".join(vary),
            hint="set keys of the scene instead, or compare without effects",
        )  # fmt: skip
    plan = plan_breakdown(request, registry, changes) if effects else make_plan(request, vary, registry, changes)
    given: dict[str, Any] = {"time_limit": time_limit, "repeat": repeat, "reference": reference}
    plan = replace(plan, study=replace(plan.study, **{name: v for name, v in given.items() if v is not None}))
    if plan.study.reference not in (None, FINEST):
        _named_reference(plan.study, plan.scene.registry)
    return plan


def run_study(
    plan: Plan, driver: Driver, keep: Keep = lambda row, scene, machine: None, results_stay: bool = True
) -> Table:
    """Run every combination, and write what was measured into the folder of the driver.

    `keep` gets each row as soon as its runs are over, without the measures that need its partner. Unless `results_stay`
    in their folders, all recordings are made that would otherwise be made of them at the first look. After Ctrl-C the
    table holds what there is, and `interrupted` is True. Raises RequestError for a folder of another comparison.
    """
    folder, began = driver.folder, perf_counter()
    if folder is not None:
        _check_runs(plan, folder)

    def over(named: Source | None, one: Combination, record: Record) -> None:
        keep(row_of(plan, one, record, named), one.scene, record.summary.get("machine", machine()))
        driver.progress.told(f"{one.name}: {record.status}")

    named, records = driver.result(study_plan(plan, folder, over, results_stay))
    rows = gather(plan, records, named)
    table = Table(
        rows=rows,
        study=plan.study,
        reference=common_reference(plan, rows, named),
        further=measure_columns(plan.scene.registry),
        scene=plan.scene.data,
        scene_text=plan.scene.toml(),
        wall_s=perf_counter() - began,
        folder=folder,
        breakdown=breakdown_of(plan, records) if isinstance(plan, BreakdownPlan) else None,
        interrupted=driver.interrupted,
    )
    if folder is not None:
        with full_disk_told(folder, "the table of the comparison"):
            _write(table, plan, records, folder, results_stay)
    return table


def study_plan(
    plan: Plan, folder: Path | None, over: Callable[[Source | None, Combination, Record], None], results_stay: bool
) -> Generator[Sequence[Any], Sequence[Any], tuple[Source | None, Records]]:
    """The reference of a study that is not installed, then all combinations."""
    if plan.study.reference == FINEST:
        named: Source | None = yield from finest_plan([one.scene for one in plan.jobs], plan.contact, folder)
    else:
        named = _named_reference(plan.study, plan.scene.registry)
    told = partial(over, named)
    proofs = [None if folder is None else _proof(one.scene, results_stay) for one in plan.jobs]
    several = plan.study.repeat
    done = yield [combination_plan(one, several, proof, told) for one, proof in zip(plan.jobs, proofs, strict=True)]
    return named, dict(zip((one.name for one in plan.jobs), done, strict=True))


def _proof(scene: Scene, results_stay: bool) -> str:
    """The file that shows that the files of a run are there: its results, if they are to stay and are written."""
    recorders = scene.record.recorders
    written = recorders is None or any(spec["use"] == RECORDER for spec in recorders)
    return FILE if results_stay and written else SUMMARY


def _named_reference(study: Study, registry: Registry) -> Source | None:
    if study.reference is None:
        return None
    where = f"{study.path}, key reference" if study.path else "reference"
    return find_reference(study.reference, registry, beside=study.folder, where=where)


def _check_runs(plan: Plan, folder: Path) -> None:
    """Require that all existing runs are requested: a comparison continues as it began."""
    names = {one.name for one in plan.jobs}
    others = sorted(place.name for place in (folder / RUNS).glob("*") if place.name not in names)
    if others:
        raise RequestError(
            "the folder holds another comparison",
            where=f"results folder {folder}",
            got=f"runs {', '.join(others[:4])}",
            allowed=f"runs {', '.join(sorted(names)[:4])}{', ...' if len(names) > 4 else ''}",
            hint="repeat --vary, --set and --effects as they were, or name another folder",
        )


def _write(table: Table, plan: Plan, records: Records, folder: Path, results_stay: bool) -> None:
    folder.mkdir(parents=True, exist_ok=True)  # long runs may outlive a folder that was tidied away
    (folder / "study.toml").write_text(write_toml(plan.study.as_data()), encoding="utf-8")
    for name, record in records.items():
        if "traceback" in record.summary:
            place = folder / RUNS / name
            place.mkdir(parents=True, exist_ok=True)
            (place / "error.txt").write_text(record.summary["traceback"], encoding="utf-8")
    write_table(table, folder)
    shown = side_by_side({one.name: one.algorithm for one in plan.jobs if not one.refines})
    record_comparison(plan.scene, plan.scene.registry, folder, shown, for_good=not results_stay)
