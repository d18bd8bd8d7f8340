"""One point: a case, a contender, a slave and a level, with its error and what it cost."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from contactlab.accuracy.calibration import calibrate
from contactlab.accuracy.efficiency import best_of
from contactlab.accuracy.problem import Problem, problem_of
from contactlab.accuracy.study import CaseChoice, Contender
from contactlab.api import Job, Record
from contactlab.archive.archive import Archive, StoredRun
from contactlab.archive.keys import run_key
from contactlab.cases.record import refused, to_bytes
from contactlab.cases.run_case import evaluated, run_case, run_job, scene_of
from contactlab.errors import ContactlabError
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.cpu_limit import CpuLimitReached, cpu_limit
from contactlab.studies.measure_run import without_compilation
from contactlab.studies.run_job import be_ready
from contactlab.studies.system import machine
from contactlab.studies.worker import BEGUN, WORN

NOT_RUN = ("over-limit", "over-budget", "not-applicable", "interrupted", "waiting")
"""Statuses of points that were never begun."""


SLAVES = ("declared", "exchanged")
"""Words for the side that carries the multipliers: as the scene has it, or the other."""
LEEWAY = 2.0
"""CPU time after which a run is stopped, in limits: these do not count building, but its process's clock does."""


@dataclass(frozen=True)
class Task:
    """What a point is made from: `limit` is its CPU time [s], `repeat` how often it is run."""

    choice: CaseChoice
    contender: Contender
    swap: bool
    level: int
    limit: float
    repeat: int = 1
    folder: Path | None = None

    @property
    def slave(self) -> str:
        """Which side carries the multipliers."""
        return SLAVES[self.swap]

    def key(self) -> str:
        """Hash of everything but the sources: under it stands that the limit was not enough."""
        data = [asdict(self.choice), asdict(self.contender), self.swap, self.level, self.limit]
        return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Point:
    """One point of a study.

    slave        "declared" as in the case, or "exchanged"
    error        relative error, nan where there is none
    cpu          CPU time of each run without compilation [s]; of a case with several runs that of the dearest
    calibration  CPU time of the calibration kernel beside them [s]
    counts       steps, iterations, sweeps, nodes of the mesh, updates (cells times steps or iterations)
    memory_mib   largest memory; compile_s  CPU time of compiling or loading kernels in that process
    spent        CPU time that was used now, without compilation [s]; 0 where the archive knew it
    runs         keys of the runs in the archive
    best         error of the best approximation of the exact pressure on the same nodes, nan where there is none
    """

    case: str
    contender: str
    slave: str
    level: int
    status: str
    reason: str = ""
    error: float = math.nan
    cpu: tuple[float, ...] = ()
    calibration: float = math.nan
    counts: Mapping[str, float] = field(default_factory=dict)
    memory_mib: float = math.nan
    compile_s: float = math.nan
    spent: float = 0.0
    runs: tuple[str, ...] = ()
    best: float = math.nan

    @property
    def efficiency(self) -> float:
        """Error of the best approximation over its own: 1 is as near as its nodes allow; nan where there is none."""
        return self.best / self.error if self.finished and self.error > 0.0 else math.nan

    @property
    def finished(self) -> bool:
        """Whether it came to its end, so that its error says something."""
        return self.status == "finished" and math.isfinite(self.error)

    @property
    def cost(self) -> float:
        """Median of its CPU times [s]."""
        return float(np.median(self.cpu)) if self.cpu else math.nan


def named(task: Task, status: str, reason: str) -> Point:
    """A point without a run."""
    return Point(task.choice.label, task.contender.label, task.slave, task.level, status, reason)


def timed_out(task: Task, reason: str) -> Point:
    """The point of a run that was stopped at its limit."""
    return replace(named(task, "timed-out", reason), spent=task.limit)


def remembered(task: Task, reason: str) -> StoredRun:
    """Tells the archive that the limit was not enough, so that nobody tries again with the same one."""
    record = replace(refused(reason), status="timed-out")
    end = ("timed-out", reason, 0.0, task.limit, to_bytes(record))
    return StoredRun(task.key(), f"{task.choice.label} {task.contender.label}", "", *end, machine())


def run_point(
    task: Task, registry: Registry, archive: Path | None, report: Callable[[Any], None]
) -> tuple[Point, list[StoredRun]]:
    """Make one point; what the archive knows of this machine is not run again. Gives the runs that are new."""
    began = process_time() - _prepared()
    known = Archive(archive, write=False) if archive is not None and archive.exists() else None
    made: list[StoredRun] = []
    try:
        problem = problem_of(task.choice, registry, task.folder)
        answer = problem.measure(problem.setup(task.contender, task.swap, task.level)).answer
        if answer is not None and (why := answer.refusal(task.level)):
            return named(task, "not-applicable", why), []
        takes = [_take(task, problem, registry, known, made, number, report) for number in range(task.repeat)]
    except CpuLimitReached as stop:
        return timed_out(task, str(stop)), [*made, remembered(task, str(stop))]
    except ContactlabError as error:
        return named(task, "failed", str(error)), made
    finally:
        if known is not None:
            known.__exit__()
    point = takes[0]
    cpu = tuple(cost for take in takes for cost in take.cpu)
    calibration = float(np.median([take.calibration for take in takes]))
    spent = process_time() - _prepared() - began if made else 0.0
    return replace(point, cpu=cpu, calibration=calibration, spent=spent), made


def _take(
    task: Task, problem: Problem, registry: Registry, known: Archive | None, made: list[StoredRun], number: int,
    report: Callable[[Any], None],
) -> Point:  # fmt: skip
    """One repetition: the runs of the case, evaluated."""
    keys: list[str] = []

    def run(job: Job, scene: Scene) -> Record:
        scene = changed(scene, task.contender)
        key = run_key(job, scene) + (f"-{number}" if number else "")
        keys.append(key)
        name = f"{task.choice.label} {job.name}"
        ready = partial(_be_ready, task, problem, registry)
        return known_or_made(job, scene, (key, name), known, made, ready, report, task.limit)

    setup = problem.setup(task.contender, task.swap, task.level)
    _, done = run_case(problem.case, setup, registry, run)
    values = evaluated(problem.case, setup, done)
    point = _point(task, problem.error(setup, values), done, tuple(keys))
    return replace(point, best=best_of(problem, setup, done))


def known_or_made(
    job: Job, scene: Scene, names: tuple[str, str], known: Archive | None, made: list[StoredRun],
    ready: Callable[[], None], report: Callable[[Any], None], limit: float,
) -> Record:  # fmt: skip
    """The record that the archive knows under the first of `names`, else of a run that is made now and goes to `made`.

    ready  imports, compiles and loads what the run needs
    limit  CPU time of the run [s]
    Raises CpuLimitReached.
    """
    record = known.record(names[0], machine()) if known is not None else None
    # a record of a matrix has no calibration beside it: its time is of another load
    if record is None or "calibration_s" not in record.summary:
        ready()
        report(BEGUN)
        try:
            with cpu_limit(LEEWAY * limit):
                record = _timed(job, scene)
        except CpuLimitReached:
            report(WORN)
            raise
        made.append(_stored(*names, scene, record))
    return record


def changed(scene: Scene, contender: Contender) -> Scene:
    """The scene of a case with what a setup has no word for: enforcement and further keys. Raises SceneError."""
    changes = dict(contender.changes or {})
    if contender.enforcement is not None:
        changes |= {f"contacts.{n}.enforcement": contender.enforcement for n in range(len(scene.contacts))}
    if isinstance(contender.integrator, Mapping) and scene.integrator.get("use") == contender.integrator["use"]:
        changes |= {f"integrator.{k}": v for k, v in contender.integrator.items() if k != "use"}
    return scene.with_(changes) if changes else scene


def _timed(job: Job, scene: Scene) -> Record:
    """The record of a run, with the calibration before and after it in its summary."""
    before = calibrate()
    record = run_job(job, scene)
    return replace(record, summary={**record.summary, "calibration_s": min(before, calibrate())})


_preparations: list[float] = []
"""CPU times [s] that this process has taken to be ready."""


def _prepared() -> float:
    return sum(_preparations)


def _be_ready(task: Task, problem: Problem, registry: Registry) -> None:
    """Import, compile and load all that the task calls, by tiny steps on its coarsest mesh: no cost of its runs."""
    began = process_time()
    jobs = problem.case.plan(problem.setup(task.contender, task.swap, 1), {})
    for job in jobs[:1]:
        with suppress(Exception):  # what is wrong is wrong in the run itself, and told there
            be_ready(changed(scene_of(job, registry), task.contender))
    _preparations.append(process_time() - began)


def cost_of(record: Record) -> float:
    """CPU time of a run without imports, building and compilation [s]."""
    return without_compilation({"run_cpu_s": 0.0, **record.summary.get("cost", {})}, "run_cpu_s")


def _point(task: Task, error: float, done: Mapping[str, Record], keys: tuple[str, ...]) -> Point:
    name = max(done, key=lambda each: cost_of(done[each]))
    dearest = done[name]
    ended = [record for record in done.values() if not record.finished]
    status, reason = (ended[0].status, ended[0].reason) if ended else ("finished", "")
    if not ended and not math.isfinite(error):
        status, reason = "failed", "the error could not be evaluated"
    summary, cost = dearest.summary, dearest.summary.get("cost", {})
    return Point(
        task.choice.label, task.contender.label, task.slave, task.level, status, reason,
        error if status == "finished" else math.nan,
        (cost_of(dearest),),
        float(summary.get("calibration_s", math.nan)),
        _counts(summary),
        float(cost.get("peak_memory_mib", math.nan)),
        float(cost.get("compile_s", math.nan)),
        runs=keys,
    )  # fmt: skip


def _counts(summary: Mapping[str, Any]) -> dict[str, float]:
    """What a run counted; without what its summary lacks."""
    counted = {"steps": "steps", "iterations": "iterations", "sweeps": "contact_sweeps", "nodes": "nodes"}
    found = {name: float(summary[key]) for name, key in counted.items() if summary.get(key) is not None}
    if "cells" in summary and "steps" in found:
        found["updates"] = summary["cells"] * (found.get("iterations") or found["steps"])
    return found


def _stored(key: str, name: str, scene: Scene, record: Record) -> StoredRun:
    work = record.summary.get("steps", 0) + record.summary.get("iterations", 0)
    end = (record.status, record.reason, work, cost_of(record), to_bytes(record))
    return StoredRun(key, name, scene.toml(), *end, machine())
