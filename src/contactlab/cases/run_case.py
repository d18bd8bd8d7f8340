"""One case put to one setup: its jobs run as it plans them, and what it finds in their records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from contactlab.api import Case, Job, Record, Setup, Watch
from contactlab.cases.record import record_of, refused
from contactlab.errors import PartError, RequestError, SimulationFailure
from contactlab.parts.registry import Registry, default_registry, split_spec
from contactlab.scene.scene import Scene, load_scene

MOST_JOBS = 40
"""Runs of one case with one setup: a case that plans more has lost its way."""

RunJob = Callable[[Job, Scene], Record]
"""How a job is run; an archive looks first whether it knows the record."""


def scene_of(job: Job, registry: Registry | None = None) -> Scene:
    """The scene of a job, checked; without recorders unless it names some. Raises SceneError or PartError."""
    registry = registry or default_registry()
    if isinstance(job.scene, str):
        scene = load_scene(job.scene, registry)
    else:
        scene = Scene.from_data({"name": job.name, **job.scene}, registry=registry)
    return scene.with_({"record.recorders": [], "record.frames": job.frames, **job.changes})


def watches_of(job: Job, registry: Registry) -> dict[str, Watch]:
    """The watches of a job by name. Raises PartError where one is not installed."""
    found: dict[str, Watch] = {}
    for number, spec in enumerate(job.watch):
        use, fields = split_spec("watch", spec, f"watch.{number}")
        name = str(fields.pop("name", use))
        if name in found:
            raise PartError("two watches have the same name", where=f"job {job.name}", got=name, hint="give a name key")
        found[name] = registry.make("watch", {"use": use, **fields}, f"job {job.name}, watch.{number}")
    return found


def run_job(job: Job, scene: Scene) -> Record:
    """Run one job; whatever becomes of it is its record."""
    from contactlab.run.simulation import simulate

    try:
        watches = watches_of(job, scene.registry)
        results = simulate(scene, registry=scene.registry, watch=watches, work=job.work, guards=job.guards)
    except RequestError as error:
        return refused(str(error))
    except SimulationFailure as error:
        # a failure before the first step: contact that starts in an overlap, say
        return replace(refused(error.reason), status=error.status)
    return record_of(results, job)


def run_case(
    case: Case, setup: Setup, registry: Registry | None = None, run: RunJob = run_job, work: float | None = None
) -> tuple[dict[str, Job], dict[str, Record]]:
    """All jobs of a case and their records, by name; `work` stands in for the limit of jobs that set none.

    A job whose scene is refused ends the case: what follows from it cannot be planned.
    """
    registry = registry or default_registry()
    jobs: dict[str, Job] = {}
    done: dict[str, Record] = {}
    while fresh := [job for job in case.plan(setup, done) if job.name not in done]:
        for job in fresh:
            jobs[job.name] = job if work is None or job.work < work else replace(job, work=work)
            done[job.name] = _run(jobs[job.name], registry, run)
            if done[job.name].status == "refused":
                return jobs, done
        if len(done) > MOST_JOBS:
            raise PartError(f"the case plans more than {MOST_JOBS} runs", where=type(case).__name__)
    return jobs, done


def _run(job: Job, registry: Registry, run: RunJob) -> Record:
    try:
        scene = scene_of(job, registry)
    except RequestError as error:
        return refused(str(error))
    return run(job, scene)


def evaluated(case: Case, setup: Setup, done: Mapping[str, Record]) -> dict[str, float]:
    """The numbers that a case finds; what cannot be found because a run failed is left out.

    Raises PartError where all runs came to their end and the case raised nevertheless.
    """
    try:
        return {name: float(value) for name, value in case.evaluate(setup, done).items()}
    except Exception as error:
        if all(record.finished for record in done.values()):
            text = f"the case raised {type(error).__name__} when it was evaluated: {error}"
            raise PartError(text, where=type(case).__name__) from error
        return {}


def with_fields(case: Case, values: Mapping[str, Any]) -> Case:
    """Make a copy of the case with other values of its fields."""
    return replace(case, **values) if values else case  # type: ignore[type-var]
