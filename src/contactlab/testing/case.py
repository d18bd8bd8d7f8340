"""Checks of cases: they are data, plan scenes that can be built, and name their measures with reasons."""

from __future__ import annotations

import json
import math
import pickle
from collections.abc import Iterator
from dataclasses import fields, replace

from contactlab.api import Case, Job, Record, Setup
from contactlab.cases.run_case import MOST_JOBS, evaluated, scene_of, watches_of
from contactlab.parts.registry import default_registry
from contactlab.scene.fields import as_data
from contactlab.testing.assertions import Check, require, tell
from contactlab.testing.partners import partners, usual_algorithm


def setups(case: Case) -> Iterator[Setup]:
    """Every integrator and element of the case, with a shipped contact algorithm; either slave if it applies."""
    algorithm = usual_algorithm(default_registry())
    for integrator in case.integrators:
        for element in case.elements:
            for swap in (False, True):
                setup = Setup(algorithm, swap, element, integrator)
                if not case.applies(setup):
                    yield setup


def failed(job: Job) -> Record:
    """Make the record of a run that failed."""
    return Record("diverged", "step 1: it was made to", {"status": "diverged", "guards": job.guards})


def is_data(case: Case) -> None:
    """A case pickles, compares, and its fields can be written down as JSON."""
    require(pickle.loads(pickle.dumps(case)) == case, "it differs from its copy after pickling")
    json.dumps(as_data(case))
    hash(case)


def says_what_it_asks(case: Case) -> None:
    """Title, source and family are given; axes and margin name fields, and the defaults are among their values."""
    names = {field.name for field in fields(case)}  # type: ignore[arg-type]
    require(all((case.title, case.source, case.family)), "title, source or family is empty")
    for name, values in case.axes.items():
        require(name in names, f"axes: got {name}, allowed: its fields ({', '.join(sorted(names))})")
        require(len(values) == len(set(values)) > 1, f"axes: {name} has {values}, needed: two or more different values")
    require(case.margin is None or case.margin[0] in names, f"margin: got {case.margin}, allowed: one of its fields")
    require(len(case.integrators) > 0 and len(case.elements) > 0, "integrators or elements is empty")


def measures_with_reasons(case: Case) -> None:
    """Every number has its own name, and every judged one a reason for its tolerance."""
    judged = [measure for setup in setups(case) for measure in case.measures(setup) if measure.role != "reported"]
    require(len(judged) > 0, "no setup has a judged measure")
    for setup in setups(case):
        measures = case.measures(setup)
        names = [measure.name for measure in measures]
        require(len(names) == len(set(names)), f"two measures have the same name: {', '.join(names)}")
        for measure in measures:
            is_judged = measure.role != "reported"
            bounded = math.isfinite(measure.least) or math.isfinite(measure.most)
            require(is_judged == bounded, f"{measure.name} is {measure.role} with bounds {measure.least, measure.most}")
            require(bool(measure.why) or not is_judged, f"the tolerance of {measure.name} has no reason (why)")


def plans_scenes(case: Case) -> None:
    """Every job of every setup is a scene that can be read, with installed watches and unique names."""
    registry = default_registry()
    for setup in setups(case):
        jobs = case.plan(setup, {})
        require(len(jobs) > 0, "it plans no run at all")
        require(len({job.name for job in jobs}) == len(jobs), "two jobs have the same name")
        for job in jobs:
            scene_of(job, registry)
            watches_of(job, registry)


def plans_what_is_asked(case: Case) -> None:
    """Jobs follow the setup: another algorithm, slave, element or integrator gives other scenes."""
    registry = default_registry()
    algorithms = partners(registry, "contact")
    first = next(setups(case), None)
    if first is None:
        return
    changed: dict[str, Setup] = {
        "algorithm": replace(first, algorithm=algorithms[-1]),
        "swap": replace(first, swap=not first.swap),
        "element": replace(first, element=case.elements[-1]),
        "integrator": replace(first, integrator=case.integrators[-1]),
    }
    planned = _scenes(case, first)
    for name, setup in changed.items():
        if getattr(setup, name) == getattr(first, name) or case.applies(setup):
            continue
        require(_scenes(case, setup) != planned, f"its runs do not depend on the {name} of the setup")
    if _scenes(case, replace(first, level=2)) == planned:
        tell("its runs are the same at level 2: nothing is refined")


def axes_change_the_runs(case: Case) -> None:
    """Another value of an axis gives other scenes."""
    first = next(setups(case), None)
    if first is None:
        return
    for name, values in case.axes.items():
        planned = [_scenes(replace(case, **{name: value}), first) for value in values]  # type: ignore[type-var]
        alike = all(one == planned[0] for one in planned)
        require(not alike, f"its runs do not depend on {name}, one of its axes")


def _scenes(case: Case, setup: Setup) -> list[object]:
    return [(job.scene, dict(job.changes)) for job in case.plan(setup, {})]


def outlives_failures(case: Case) -> None:
    """Planning ends, and evaluation leaves numbers out, if every run fails."""
    for setup in setups(case):
        done: dict[str, Record] = {}
        while fresh := [job for job in case.plan(setup, done) if job.name not in done]:
            done |= {job.name: failed(job) for job in fresh}
            require(len(done) <= MOST_JOBS, f"it plans more than {MOST_JOBS} runs")
        values = evaluated(case, setup, done)
        wanted = {measure.name for measure in case.measures(setup)}
        require(set(values) <= wanted, f"evaluate returns what is not a measure: {', '.join(set(values) - wanted)}")


CHECKS: tuple[Check, ...] = (
    is_data,
    says_what_it_asks,
    measures_with_reasons,
    plans_scenes,
    plans_what_is_asked,
    axes_change_the_runs,
    outlives_failures,
)
"""All checks of cases."""
