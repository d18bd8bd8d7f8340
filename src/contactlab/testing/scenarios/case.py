"""Scenarios of cases: they are put to an algorithm, for a while."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Mapping

from contactlab.api import Case, Record, Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.errors import PartError
from contactlab.testing.assertions import require
from contactlab.testing.partners import usual_algorithm
from contactlab.testing.spoilt import spoilt, spoilt_curves, unknown
from contactlab.testing.subject import Subject

WAYS = ((1, False), (2, False), *((seed, True) for seed in range(3, 9)))
"""Seeds of the records with other numbers, and whether signs change, too."""
WORK = 300.0
"""Steps and iterations after which its runs are stopped: they have begun, and short ones have ended."""


def is_put_to_an_algorithm(subject: Subject) -> None:
    """Runs of the case begin, and `evaluate` returns its measures."""
    case: Case = subject.make()
    setup = Setup(usual_algorithm(subject.registry), False, case.elements[0], case.integrators[0])
    _, done = run_case(case, setup, subject.registry, work=WORK)
    for name, record in done.items():
        require(record.status != "refused", f"{name}: the run was refused: {record.reason}")
    if all(record.finished for record in done.values()):
        found = set(evaluated(case, setup, done))
        measured = {measure.name for measure in case.measures(setup)}
        require(found <= measured, f"evaluate returns what is not a measure: {', '.join(sorted(found - measured))}")
        require(found == measured, f"all runs finished, but it returns no {', '.join(sorted(measured - found))}")
        _follows_from_its_records(case, setup, done)


def _follows_from_its_records(case: Case, setup: Setup, done: Mapping[str, Record]) -> None:
    """Other numbers in any of the records give other numbers; NaN meets no measure; records are only read."""
    before = pickle.dumps(dict(done))
    plain = evaluated(case, setup, done)
    require(pickle.dumps(dict(done)) == before, "it changes the records that it evaluates")
    judged = {measure.name: measure for measure in case.measures(setup) if measure.role != "reported"}
    moved: set[str] = set()
    for name in done:
        tried = [_found(case, setup, {**done, name: spoilt(done[name], *way)}) for way in WAYS]
        changed = {key for found in tried if found for key in plain if repr(found.get(key)) != repr(plain[key])}
        if not any(tried):  # it raises, and so reads them
            changed |= plain.keys()
        # a run may be there to plan the next one by
        planned = _plan(case, setup, {}) == _plan(case, setup, {**done, name: spoilt(done[name])})
        require(changed or not planned, f"its numbers do not depend on the record of its run {name}")
        moved |= changed
    still = [key for key in judged if key not in moved and plain[key] != 0.0]
    require(not still, f"it finds the same {', '.join(still)} in records with other numbers")
    others = _found(case, setup, {name: spoilt_curves(one) for name, one in done.items()})
    for key, value in _found(case, setup, {name: unknown(one) for name, one in done.items()}).items():
        blind = key in judged and judged[key].met(value) and others.get(key, value) != plain[key]
        require(not blind, f"{key} is {value:.3g}, and met, in curves of NaN, needed: NaN")


def _plan(case: Case, setup: Setup, done: Mapping[str, Record]) -> list[object]:
    return [(job.name, job.scene, dict(job.changes)) for job in case.plan(setup, done)]


def _found(case: Case, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
    """Return what the case finds in changed records; nothing if it raises, for example if no node is in contact."""
    with warnings.catch_warnings(action="ignore"):
        try:
            return evaluated(case, setup, done)
        except PartError:
            return {}


SCENARIOS = (is_put_to_an_algorithm,)
