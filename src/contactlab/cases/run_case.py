"""Plan and evaluation of one case with one setup: its jobs, and its numbers from their records."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from contactlab.api import Case, Job, Potential, Record, Setup
from contactlab.api.case import Spec
from contactlab.errors import PartError, RequestError
from contactlab.jobs.perform import made, watches_of
from contactlab.jobs.record import refused
from contactlab.jobs.run import Run, here
from contactlab.parts.registry import Registry, default_registry, split_spec
from contactlab.scene.scene import Scene, load_scene

MOST_JOBS = 40
"""Runs of one case with one setup: a case that plans more is in error."""

RunJob = Callable[[Job, Scene], Record]
"""Runs a job in this process."""
Done = tuple[dict[str, Job], dict[str, Record]]
"""Jobs of a case and their records, by name."""

__all__ = [
    "MOST_JOBS", "case_plan", "declined", "evaluated", "is_potential", "run_case", "run_job", "scene_of", "unfit",
    "watches_of", "with_fields",
]  # fmt: skip

run_job: RunJob = made


def scene_of(job: Job, registry: Registry | None = None, enforcement: Spec = "") -> Scene:
    """The scene of a job, checked; without recorders unless it names some. Raises SceneError or PartError.

    enforcement  of all contacts, if a setup has one
    """
    registry = registry or default_registry()
    changes = {"record.recorders": [], "record.frames": job.frames, **job.changes}
    if isinstance(job.scene, str):
        scene = load_scene(job.scene, registry, changes)
    else:
        scene = Scene.from_data({"name": job.name, **job.scene}, registry=registry).with_(changes)
    own = {f"contacts.{n}.enforcement": enforcement for n in range(len(scene.contacts))} if enforcement else {}
    return scene.with_(own) if own else scene


def is_potential(spec: Any, registry: Registry) -> bool:
    """Return whether this contact algorithm is a potential; an algorithm that cannot be imported is not."""
    try:
        return issubclass(registry.part_class("contact", split_spec("contact", spec, "")[0]), Potential)
    except RequestError:
        return False


def unfit(case: Case, setup: Setup, registry: Registry) -> str:
    """Why a case cannot be run with this setup, also by what its contact algorithm refuses; empty if it can."""
    why = case.applies(setup)
    if why:
        return why
    algorithm = registry.make("contact", setup.algorithm)
    if not isinstance(algorithm, Potential) and algorithm.half_pass() is None:
        return ""
    for job in case.plan(setup, {}):
        try:
            _refuse(scene_of(job, registry, setup.enforcement), registry)
        except RequestError as error:
            return error.problem
    return ""


def _refuse(scene: Scene, registry: Registry) -> None:
    """Raise RequestError for a scene that gives a potential or half passes what they cannot take."""
    from contactlab.model.contact.checks import refuse_half_passes
    from contactlab.model.contact.potential_start import refuse_potential

    integrator = registry.make("integrator", scene.integrator)
    for contact in scene.contacts:
        algorithm = registry.make("contact", contact.algorithm)
        friction = registry.make("friction", contact.friction) if contact.friction else None
        if isinstance(algorithm, Potential):
            refuse_potential(algorithm, contact, integrator, friction, "")
        elif algorithm.half_pass() is not None:
            enforcement = registry.make("enforcement", contact.enforcement or integrator.enforcement())
            refuse_half_passes(contact, enforcement, friction, "", "")


def declined(setup: Setup, done: Mapping[str, Record]) -> str:
    """Why the enforcement of a setup refuses a scene of the case, as its run found out; empty if it takes all."""
    return next((r.reason for r in done.values() if setup.enforcement and r.status == "refused"), "")


def case_plan(
    case: Case, setup: Setup, registry: Registry, asked: Callable[[Job, Scene], Run], work: float = math.inf
) -> Generator[Sequence[Run], Sequence[Record], Done]:
    """All jobs of a case and their records; `asked` makes a run of a job, `work` limits jobs that set no limit.

    A job whose scene is refused ends the case, because what follows from it cannot be planned.
    """
    jobs: dict[str, Job] = {}
    done: dict[str, Record] = {}
    while fresh := [job for job in case.plan(setup, done) if job.name not in done]:
        runs: dict[str, Run] = {}
        for job in fresh:
            jobs[job.name] = job if job.work < work else replace(job, work=work)
            try:
                runs[job.name] = asked(jobs[job.name], scene_of(job, registry, setup.enforcement))
            except RequestError as error:
                done[job.name] = refused(str(error))
                break
        records = yield list(runs.values())
        done = {**done, **dict(zip(runs, records, strict=True))}
        done = {name: done[name] for name in jobs}
        if any(record.status in ("refused", "interrupted") for record in done.values()):
            break
        if len(done) > MOST_JOBS:
            raise PartError(f"the case plans more than {MOST_JOBS} runs", where=type(case).__name__)
    return jobs, done


def run_case(
    case: Case, setup: Setup, registry: Registry | None = None, run: RunJob = run_job, work: float | None = None
) -> Done:
    """Run all jobs of a case in this process; returns them and their records."""
    plan = case_plan(case, setup, registry or default_registry(), _in_passing, math.inf if work is None else work)
    found: Done = here(plan, lambda one: run(one.job, one.scene))
    return found


def _in_passing(job: Job, scene: Scene) -> Run:
    return Run(job, scene, job.name)


def evaluated(case: Case, setup: Setup, done: Mapping[str, Record]) -> dict[str, float]:
    """The numbers that a case finds; what cannot be found because a run failed is left out.

    Raises PartError if all runs finished and the case raised nevertheless.
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
