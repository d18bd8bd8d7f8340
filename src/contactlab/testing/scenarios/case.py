"""Scenarios of cases: they are put to an algorithm, for a while."""

from __future__ import annotations

from contactlab.api import Case, Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.testing.assertions import require
from contactlab.testing.partners import usual_algorithm
from contactlab.testing.spoilt import spoilt
from contactlab.testing.subject import Subject

WORK = 300.0
"""Steps and iterations after which its runs are stopped: they have begun, and short ones are over."""


def is_put_to_an_algorithm(subject: Subject) -> None:
    """Its runs begin, and what it finds when they end is what it measures."""
    case: Case = subject.make()
    setup = Setup(usual_algorithm(subject.registry), False, case.elements[0], case.integrators[0])
    _, done = run_case(case, setup, subject.registry, work=WORK)
    for name, record in done.items():
        require(record.status != "refused", f"{name}: the run was refused: {record.reason}")
    if all(record.finished for record in done.values()):
        found = set(evaluated(case, setup, done))
        measured = {measure.name for measure in case.measures(setup)}
        require(found <= measured, f"it finds what is no measure of it: {', '.join(sorted(found - measured))}")
        require(found == measured, f"it does not find {', '.join(sorted(measured - found))}, though its runs finished")
        other = evaluated(case, setup, {name: spoilt(record) for name, record in done.items()})
        same = [name for name in measured if repr(other.get(name)) == repr(evaluated(case, setup, done)[name])]
        require(set(same) != measured, "it finds the same numbers in records in which every number is another")


SCENARIOS = (is_put_to_an_algorithm,)
