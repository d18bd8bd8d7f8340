"""Run every combination of a study side by side, and gather what came of it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, as_completed
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from contactlab.errors import RequestError
from contactlab.parts.machine import usable_cores
from contactlab.parts.registry import Registry
from contactlab.run.folders import claimed_folder, full_disk_told, made_folder
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import write_toml
from contactlab.studies import run_job
from contactlab.studies.awaited import awaited
from contactlab.studies.call import Call, Pool
from contactlab.studies.cost_breakdown import BreakdownPlan, breakdown_of, plan_breakdown
from contactlab.studies.find_reference import Source, find_reference
from contactlab.studies.gather import common_reference, gather, row_of
from contactlab.studies.installed_measures import measure_columns
from contactlab.studies.plan import Job, Plan, Vary, make_plan
from contactlab.studies.progress import Bars, MakeBars, no_bars
from contactlab.studies.recordings import record_comparison, side_by_side
from contactlab.studies.resume import sigterm_as_ctrl_c, stored_outcomes
from contactlab.studies.run_job import Outcome
from contactlab.studies.scheduler import LOCAL, checked_scheduler, open_pool
from contactlab.studies.study import FINEST, Study
from contactlab.studies.table import Row, Table
from contactlab.studies.table_files import write_table
from contactlab.studies.worker import BEGUN

Keep = Callable[[Row, Scene, str], None]
"""Called with a row, its scene and the name of the machine that made it."""


MakeFinest = Callable[[Sequence[Scene], int, Path | None, int | None, bool, str], Source]
"""Makes references of scenes from runs on finer meshes: `contactlab.studies.finest.make_finest`."""


def no_finest(*wanted: Any) -> Source:
    """Refuse: runs that make a reference have none themselves."""
    raise RequestError("a reference cannot be made from finer meshes here", where="reference", got=FINEST)


def run_study(
    scene_or_study: Scene | Study | str | Path,
    vary: Vary | None = None,
    out: str | Path | None = None,
    jobs: int | None = None,
    registry: Registry | None = None,
    bars: MakeBars = no_bars,
    changes: Mapping[str, Any] | None = None,
    effects: bool = False,
    resume: bool = False,
    time_limit: float | None = None,
    scheduler: str = LOCAL,
    keep: Keep = lambda row, scene, machine: None,
    repeat: int | None = None,
    reference: str | None = None,
    finest: MakeFinest = no_finest,
    results_stay: bool = True,
) -> Table:
    """Run every combination, and write what was measured into `out`; see `contactlab.comparison.compare`.

    `bars` shows the progress; `time_limit` is the wall time that one run may take [s]; `keep` is given each row
    as soon as its run is over, without the measures that need its partner. Unless `results_stay` in their folders, all
    recordings are made that would otherwise be made of them at the first look. After Ctrl-C or SIGTERM the
    table holds what there is, and `interrupted` is True. Raises RequestError when the request itself is wrong.
    """
    plan = _repeated(_limited(_plan(scene_or_study, vary, registry, changes, effects), time_limit), repeat)
    plan = plan if reference is None else replace(plan, study=replace(plan.study, reference=reference))
    named = None if plan.study.reference == FINEST else _named_reference(plan.study, plan.scene.registry)
    pool_of = partial(open_pool, checked_scheduler(scheduler), _checked_jobs(jobs))
    folder = _folder(out, resume)
    if plan.study.reference == FINEST:
        place = None if folder is None else folder / FINEST
        named = finest([job.scene for job in plan.jobs], plan.contact, place, jobs, resume, scheduler)
    done = stored_outcomes(plan, folder) if resume and folder is not None else {}
    began = perf_counter()

    def over(job: Job, outcome: Outcome) -> None:
        keep(row_of(plan, job, outcome, named), job.scene, outcome.machine)

    with bars(plan.jobs) as shown, sigterm_as_ctrl_c():
        outcomes, interrupted = _run_all(plan, done, folder, partial(pool_of, folder), shown, over)
    if interrupted and folder is not None:
        outcomes |= stored_outcomes(plan, folder)  # over, but its answer was still on the way
    rows = gather(plan, outcomes, named)
    table = Table(
        rows=rows,
        study=plan.study,
        reference=common_reference(plan, rows, named),
        further=measure_columns(plan.scene.registry),
        scene=plan.scene.data,
        scene_text=plan.scene.toml(),
        wall_s=perf_counter() - began,
        folder=folder,
        breakdown=breakdown_of(plan, outcomes) if isinstance(plan, BreakdownPlan) else None,
        interrupted=interrupted,
    )
    if folder is not None:
        with full_disk_told(folder, "the table of the comparison"):
            _write(table, plan, outcomes, folder, results_stay)
    return table


def _folder(out: str | Path | None, resume: bool) -> Path | None:
    if out is None:
        if resume:
            raise RequestError("a comparison can only be taken up in its folder", where="resume", allowed="a folder")
        return None
    return made_folder(Path(out)) if resume else claimed_folder(Path(out))


def _plan(request: Any, vary: Vary | None, registry: Registry | None, changes: Any, effects: bool) -> Plan:
    if not effects:
        return make_plan(request, vary, registry, changes)
    if vary:
        raise RequestError(
            "effects are taken out of one scene, nothing else is varied beside", where="vary", got=", ".join(vary),
            hint="set keys of the scene instead, or compare without effects",
        )  # fmt: skip
    return plan_breakdown(request, registry, changes)


def _limited(plan: Plan, time_limit: float | None) -> Plan:
    """The plan with this limit of time instead of the study's."""
    if time_limit is None:
        return plan
    if not 0.0 < time_limit < math.inf:
        raise RequestError("no time to run in", where="time_limit", got=time_limit, allowed="seconds, above 0")
    return replace(plan, study=replace(plan.study, time_limit=float(time_limit)))


def _repeated(plan: Plan, repeat: int | None) -> Plan:
    """The plan with so many runs of each combination instead of the study's."""
    if repeat is None:
        return plan
    if repeat < 1:
        raise RequestError("there must be at least one run", where="repeat", got=repeat, allowed="1 or more")
    return replace(plan, study=replace(plan.study, repeat=repeat))


def _named_reference(study: Study, registry: Registry) -> Source | None:
    if study.reference is None:
        return None
    where = f"{study.path}, key reference" if study.path else "reference"
    return find_reference(study.reference, registry, beside=study.folder, where=where)


def _checked_jobs(jobs: int | None) -> int:
    if jobs is not None and jobs < 1:
        raise RequestError("there must be at least one process", where="jobs", got=jobs, allowed="1 or more")
    return jobs or usable_cores()


def _write(table: Table, plan: Plan, outcomes: Mapping[str, Outcome], folder: Path, results_stay: bool) -> None:
    folder.mkdir(parents=True, exist_ok=True)  # long runs may outlive a folder that was tidied away
    (folder / "study.toml").write_text(write_toml(plan.study.as_data()), encoding="utf-8")
    for name, outcome in outcomes.items():
        if outcome.traceback:
            place = folder / "runs" / name
            place.mkdir(parents=True, exist_ok=True)
            (place / "error.txt").write_text(outcome.traceback, encoding="utf-8")
    write_table(table, folder)
    shown = side_by_side({job.name: job.algorithm for job in plan.jobs if not job.refines})
    record_comparison(plan.scene, plan.scene.registry, folder, shown, for_good=not results_stay)


# --- running ---------------------------------------------------------------------------------------


def _run_all(
    plan: Plan,
    done: Mapping[str, Outcome],
    folder: Path | None,
    pool_of: Callable[[], Pool],
    bars: Bars,
    over: Callable[[Job, Outcome], None],
) -> tuple[dict[str, Outcome], bool]:
    """Outcomes by job name, those that are `done` among them, and whether the user stopped it."""
    outcomes = dict(done)
    for name, outcome in done.items():
        bars.finish(name, outcome.status)
    rest = [job for job in plan.jobs if job.name not in done]
    if not rest:
        return outcomes, False
    futures: dict[Future[Outcome], Job] = {}
    with pool_of() as pool:
        try:
            _warm_up(pool, plan, rest, bars)
            # the study's own runs, then the longest first, so that no core waits at the end
            queue = sorted(rest, key=lambda job: (job.refines, -job.scene.level))
            futures = {_submit(pool, plan, job, folder, bars): job for job in queue}
            for future in as_completed(futures):
                job, outcome = futures[future], awaited(future)
                outcomes[job.name] = outcome
                over(job, outcome)
                bars.finish(job.name, outcome.status)
        except KeyboardInterrupt:
            stopped = {job.name: Outcome("interrupted", "stopped before it began") for job in rest}
            return {**stopped, **_stop(pool, futures), **outcomes}, True
    return outcomes, False


def _stop(pool: Pool, futures: Mapping[Future[Outcome], Job]) -> dict[str, Outcome]:
    """What becomes of the runs after Ctrl-C: they save their state, or are ended at once after another one."""
    running = [job.name for future, job in futures.items() if future.running()]
    try:
        if running:
            print(_waiting_for(running), file=sys.stderr, flush=True)
        pool.stop()
        return {job.name: awaited(future, stopped=True) for future, job in futures.items()}
    except KeyboardInterrupt:
        print("contactlab: ending them at once; what was saved last is kept", file=sys.stderr, flush=True)
        pool.kill()
        return {job.name: awaited(future, stopped=True) for future, job in futures.items()}


def _waiting_for(names: Sequence[str]) -> str:
    shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    runs = f"{len(names)} run{'s' * (len(names) > 1)}"
    return f"contactlab: stopping, once {runs} saved the state: {shown} (Ctrl-C again ends what runs at once)"


def _warm_up(pool: Pool, plan: Plan, jobs: Sequence[Job], bars: Bars) -> None:
    """Compile once, in one process, before several would compile the same side by side."""
    first = {run_job.composition(job.scene): job for job in reversed(jobs)}
    bars.say("compiling kernels")
    for job in first.values():
        # Whatever is wrong here is wrong in the run itself, and told there.
        pool.submit(Call(run_job.warm_up, (job.scene,), bars.say, _call_limit(plan))).exception()
    bars.say("")


def _submit(pool: Pool, plan: Plan, job: Job, folder: Path | None, bars: Bars) -> Future[Outcome]:
    place = None if folder is None else (folder / "runs" / job.name).resolve()

    def report(message: Any) -> None:
        if message != BEGUN:
            bars.advance(job.name, *message)

    arguments = job.scene, place, plan.contact, plan.study.repeat
    return pool.submit(Call(run_job.run, arguments, report, _call_limit(plan), place))


def _call_limit(plan: Plan) -> float | None:
    """Time for all repetitions of one run [s]."""
    limit = plan.study.time_limit
    return None if limit is None else limit * plan.study.repeat
