"""Points: a case, a method, a slave and a level, with error and cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from contactlab.accuracy.efficiency import best_of
from contactlab.accuracy.problem import Problem
from contactlab.accuracy.study import CaseChoice, Contender
from contactlab.api import Job, Record
from contactlab.cases.run_case import case_plan, declined, evaluated
from contactlab.errors import ContactlabError
from contactlab.jobs.run import Run, always
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.measure_run import without_compilation

UNFINISHED = ("not-run", "interrupted", "timed-out")
NOT_RUN = ("over-limit", "over-budget", "not-applicable", "interrupted", "waiting")
"""Statuses of points that were never begun."""


SLAVES = ("declared", "exchanged")
"""Words for the side that carries the multipliers: as the scene has it, or the other."""


@dataclass(frozen=True)
class Task:
    """Settings of a point: `limit` of its CPU time [s], `repeat` of runs that take less than `short` [s]."""

    choice: CaseChoice
    contender: Contender
    swap: bool
    level: int
    limit: float
    repeat: int = 1
    short: float = math.inf

    @property
    def slave(self) -> str:
        """Side that carries the multipliers."""
        return SLAVES[self.swap]


@dataclass(frozen=True)
class Point:
    """Point of a study.

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
        """Return whether the run finished, so that its error is meaningful."""
        return self.status == "finished" and math.isfinite(self.error)

    @property
    def cost(self) -> float:
        """Median of its CPU times [s]."""
        return float(np.median(self.cpu)) if self.cpu else math.nan


def named(task: Task, status: str, reason: str) -> Point:
    """A point without a run."""
    return Point(task.choice.label, task.contender.label, task.slave, task.level, status, reason)


def point_plan(
    task: Task, problem: Problem, registry: Registry, rank: tuple[float, ...] = (), unless: Callable[[], str] = always
) -> Generator[Sequence[Any], Sequence[Any], Point]:
    """Make one point; `unless` says why its runs do not begin any more."""
    try:
        setup = problem.setup(task.contender, task.swap, task.level)
        answer = problem.measure(setup).answer
        if answer is not None and (why := answer.refusal(task.level)):
            return named(task, "not-applicable", why)
        takes: Sequence[Point] = yield [_take_plan(task, problem, registry, 0, rank, unless)]
        if takes[0].finished and takes[0].cost < task.short:
            others: Sequence[Point] = yield [
                _take_plan(task, problem, registry, n, rank, unless) for n in range(1, task.repeat)
            ]
            takes = [*takes, *others]
    except ContactlabError as error:
        return named(task, "failed", str(error))
    cpu = tuple(cost for take in takes for cost in take.cpu)
    calibration = float(np.median([take.calibration for take in takes]))
    point = replace(takes[0], cpu=cpu, calibration=calibration, spent=sum(take.spent for take in takes))
    if point.cpu and point.cost > task.limit:
        reason = f"took {point.cost:.3g} CPU s, the limit is {task.limit:g}"
        return replace(point, status="timed-out", reason=reason, error=math.nan)
    return point


def _take_plan(
    task: Task, problem: Problem, registry: Registry, number: int, rank: tuple[float, ...], unless: Callable[[], str]
) -> Generator[Sequence[Run], Sequence[Record], Point]:
    """Run one repetition: the runs of the case, evaluated."""
    keys: list[str] = []

    def asked(job: Job, scene: Scene) -> Run:
        run = Run(
            job, changed(scene, task.contender), f"{task.choice.label} {job.name}", number=number, timed=True,
            cpu_limit=task.limit, rank=rank, unless=unless,
        )  # fmt: skip
        keys.append(run.key)
        return run

    setup = problem.setup(task.contender, task.swap, task.level)
    try:
        _, done = yield from case_plan(problem.case, setup, registry, asked)
        failed = next((record for record in done.values() if record.status in UNFINISHED), None)
        if failed is not None:
            status = "over-budget" if failed.status == "not-run" else failed.status
            spent = task.limit if "cpu_limit" in failed.summary and not failed.summary.get("known") else 0.0
            return replace(named(task, status, failed.reason), spent=spent)
        if why := declined(setup, done):
            return named(task, "not-applicable", why)
        values = evaluated(problem.case, setup, done)
        point = _point(task, problem.error(setup, values), done, tuple(keys))
        return replace(point, best=best_of(problem, setup, done))
    except ContactlabError as error:
        return named(task, "failed", str(error))
    except Exception as error:  # the case raised
        return named(task, "failed", f"{type(error).__name__}: {error}")


def spent_on(record: Record) -> float:
    """CPU time [s] that a run took now, without compilation; 0 if the archive knew it."""
    if record.summary.get("known"):
        return 0.0
    compiled = float(record.summary.get("cost", {}).get("compile_s", 0.0))
    return max(0.0, float(record.summary.get("process_s", 0.0)) - compiled)


def changed(scene: Scene, contender: Contender) -> Scene:
    """The scene of a case with what a setup has no word for: further keys. Raises SceneError."""
    changes = dict(contender.changes or {})
    if isinstance(contender.integrator, Mapping) and scene.integrator.get("use") == contender.integrator["use"]:
        changes |= {f"integrator.{k}": v for k, v in contender.integrator.items() if k != "use"}
    return scene.with_(changes) if changes else scene


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
    # what a run counted; without what its summary lacks
    counted = {"steps": "steps", "iterations": "iterations", "sweeps": "contact_sweeps", "nodes": "nodes"}
    counts = {name: float(summary[key]) for name, key in counted.items() if summary.get(key) is not None}
    if "cells" in summary and "steps" in counts:
        counts["updates"] = summary["cells"] * (counts.get("iterations") or counts["steps"])
    return Point(
        task.choice.label, task.contender.label, task.slave, task.level, status, reason,
        error if status == "finished" else math.nan,
        (cost_of(dearest),),
        float(summary.get("calibration_s", math.nan)),
        counts,
        float(cost.get("peak_memory_mib", math.nan)),
        float(cost.get("compile_s", math.nan)),
        spent=sum(map(spent_on, done.values())),
        runs=keys,
    )  # fmt: skip
