"""What a cell is: every verdict from a record made for it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import pytest

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, invariant, no_limit, reported
from contactlab.cases.verdict import judge, verdict_of, worst

GOOD = Record("finished", "", {"status": "finished", "guards": True, "balance": {}, "contacts": {}})
SETUP = Setup("any", integrator="any")


@dataclass(frozen=True)
class Question(Case):
    measure: Measure
    unanswerable: str = ""

    title: ClassVar[str] = "t"
    source: ClassVar[str] = "s"
    family: ClassVar[str] = "f"
    integrators: ClassVar[tuple[str, ...]] = ("any",)
    elements: ClassVar[tuple[str, ...]] = ("any",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        return ()

    def measures(self, setup: Setup) -> Sequence[Measure]:
        return (self.measure,)

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        return {}

    def ill_posed(self, setup: Setup) -> str:
        return self.unanswerable


ERROR = error("e", 0.1, "w", codes=("locking",))


@pytest.mark.parametrize(
    ("measure", "value", "verdict"),
    [
        (ERROR, 0.1, "met"),
        (ERROR, -0.29, "missed"),
        (ERROR, -0.31, "silent"),
        (ERROR, math.nan, "silent"),
        (at_most("c", 1.0, "w"), 1e9, "missed"),
        (at_most("c", 1.0, "w"), math.nan, "missed"),
        (invariant("i", 1e-9, "w"), 2e-9, "silent"),
        (invariant("i", 1e-9, "w"), 1e-9, "met"),
        (reported("r"), math.nan, "met"),
    ],
)
def test_a_finished_run(measure: Measure, value: float, verdict: str) -> None:
    assert verdict_of(measure, value, "finished") == verdict


def test_a_warning_that_names_the_miss_breaks_the_silence() -> None:
    assert verdict_of(ERROR, 1.0, "finished", frozenset({"locking"})) == "missed"
    assert verdict_of(ERROR, 1.0, "finished", frozenset({"other"})) == "silent"


def test_an_unguarded_run_is_never_silent() -> None:
    assert verdict_of(ERROR, 1.0, "finished", guarded=False) == "missed"


@pytest.mark.parametrize(
    ("status", "verdict"), [("diverged", "failed"), ("refused", "failed"), ("timed-out", "not-judged")]
)
def test_a_run_that_did_not_finish(status: str, verdict: str) -> None:
    found = judge(Question(ERROR), SETUP, {"run": replace(GOOD, status=status, reason="why")}, {})
    assert (found.verdict, found.reason) == (verdict, "why")


def test_saying_so_is_right_where_there_is_no_answer() -> None:
    stopped = {"run": replace(GOOD, status="not-converged", reason="circles")}
    assert judge(Question(ERROR, "several solutions"), SETUP, stopped, {}).verdict == "ill-posed"
    assert judge(Question(ERROR), SETUP, stopped, {}).verdict == "failed"


@pytest.mark.parametrize(
    ("ratio", "unanswerable", "verdict"),
    [(2.0, "waves grow", "ill-posed"), (2.0, "", "met"), (1.0, "waves grow", "missed")],
)
def test_finished_runs_must_show_that_there_is_no_limit(ratio: float, unanswerable: str, verdict: str) -> None:
    """What does not grow under refinement is missed, whatever the case says of the problem."""
    case = Question(no_limit("rate, cells halved over whole", 1.8, 2.2, "w"), unanswerable)
    found = judge(case, SETUP, {"run": GOOD}, {"rate, cells halved over whole": ratio})
    assert found.verdict == verdict
    assert ("halved over whole: 2" in found.reason) == (verdict == "ill-posed")


def test_numbers_that_show_nothing_about_limits_make_no_cell_ill_posed() -> None:
    assert judge(Question(ERROR, "several solutions"), SETUP, {"run": GOOD}, {"e": 0.0}).verdict == "met"
    broke = {"run": broken("ledger")}
    case = Question(no_limit("r", 1.8, 2.2, "w"), "waves grow")
    assert judge(case, SETUP, broke, {"r": 2.0}).verdict == "silent"


@pytest.mark.parametrize(("level", "verdict"), [(3, "silent"), (4, "not-applicable"), (8, "not-applicable")])
def test_no_run_is_measured_against_an_answer_that_it_could_have_made(level: int, verdict: str) -> None:
    measure = error("e", 0.1, "w", answer=Answer(1.0, "finest", 0.01, "runs at level 4", level=4))
    found = judge(Question(measure), replace(SETUP, level=level), {"run": GOOD}, {"e": 9.0})
    assert [judged.verdict for judged in found.judged if judged.measure is measure] == [verdict]


def test_the_worst_measure_is_the_cell() -> None:
    assert worst(["met", "missed", "silent", "failed"]) == "silent"
    assert worst(["met", "not-judged"]) == "not-judged"
    found = judge(Question(ERROR), SETUP, {"run": GOOD}, {"e": 0.2})
    assert found.verdict == "missed"
    assert "e is 0.2" in found.reason


def broken(code: str, value: float | None = 0.1, warned: bool = False) -> Record:
    one = {"name": "n", "code": code, "where": "", "value": value, "limit": 1e-6, "why": "w"}
    warnings = [{"code": code}] if warned else []
    return replace(GOOD, summary={**GOOD.summary, "invariants": [one], "warnings": warnings})


@pytest.mark.parametrize("record", [broken("ledger"), broken("ledger", None)])
def test_invariants_are_looked_at_in_every_cell(record: Record) -> None:
    """Whatever the case asks; a number that is none is a breach, too."""
    case = Question(at_most("c", 1.0, "w"))
    found = judge(case, SETUP, {"good": GOOD, "bad": record}, {"c": 0.0})
    assert found.verdict == "silent", found
    assert judge(case, SETUP, {"good": GOOD}, {"c": 0.0}).verdict == "met"


def test_a_breach_that_its_own_warning_names_is_missed_and_not_silent() -> None:
    found = judge(Question(at_most("c", 1.0, "w")), SETUP, {"run": broken("pressure-saw", warned=True)}, {"c": 0.0})
    assert found.verdict == "missed"
    assert "n is 0.1, allowed <= 1e-06" in found.reason


def test_of_several_runs_and_contacts_the_worst_counts() -> None:
    found = judge(
        Question(at_most("c", 1.0, "w")), SETUP, {"a": broken("ledger", 1e-7), "b": broken("ledger", 1e-3)}, {"c": 0.0}
    )
    assert [j.value for j in found.judged if j.measure.role == "invariant"] == [1e-3]
