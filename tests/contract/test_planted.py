"""Parts of strangers: right ones are not refused, planted defects are found, in words that say what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from from_source import changed, changes_of, source_of, subject_of
from planted import CATCHES, NOT_CAUGHT, PLANTED
from tiers import some

from contactlab.api import Potential
from contactlab.api.part import KINDS
from contactlab.testing import checks_for, friction, integrator, run_check
from contactlab.testing.assertions import Check
from contactlab.testing.check_part import PartReport, check_part

HERE = Path(__file__).parent
RIGHT = sorted(path.stem for path in (HERE / "right_parts").glob("*.py"))
HEATED = "outside heated/src/heated/heated_laws.py"
QUICK = ("function", "mesh", "measure", "reference", "recorder", "case")
"""Kinds whose checks take a few hundredths of a second."""
EVERY = 20  # of the defects of quick kinds in the default tier


def checked(base: str, folder: Path, changes: tuple[str, ...] = ()) -> PartReport:
    """What `contactlab check` says, up to the first failure."""
    return check_part(subject_of(base, folder, changes), until_failure=True)


def tier(names: list[tuple[str, str]]) -> list[object]:
    """Some of the quick ones in every tier, all others in the full one."""
    quick = [name for name in names if source_of(name[0])[0] in QUICK][::EVERY]
    return [n if n in quick else pytest.param(*n, marks=pytest.mark.full) for n in names]


CAUGHT = [(base, d[0]) for base, defects in PLANTED.items() for d in defects if (base, d[0]) not in NOT_CAUGHT]


@pytest.mark.parametrize(("base", "says"), tier(CAUGHT))
def test_a_planted_defect_is_found(base: str, says: str, tmp_path: Path) -> None:
    report = checked(base, tmp_path, changes_of(base, says))
    failed = [outcome for outcome in report.outcomes if outcome.status == "failed"]
    assert failed, f"{base}, {says}: not caught"
    assert len(failed[0].reason) > 20, "a failure must say what is wrong"


OUTSIDE = sorted(
    {base for base in PLANTED if " outside " in base}
    | {f"enforcement {HEATED}:CuringLayer", f"friction {HEATED}:Softening"}
)
"""Parts of tests/outside."""


@pytest.mark.parametrize(
    ("base", "says"), tier([(base, "") for base in (*(f"right {name}" for name in RIGHT), *OUTSIDE)])
)
def test_a_right_part_is_not_refused(base: str, says: str, tmp_path: Path) -> None:
    report = checked(base, tmp_path)
    assert [(o.check, o.reason) for o in report.outcomes if o.status == "failed"] == []


def name_of(check: Check) -> str:
    return f"{check.__module__.rpartition('.')[2]}.{check.__name__}"


CHECKS = {name_of(check): check for kind in KINDS for cls in (None, Potential) for check in checks_for(kind, cls)}
BY_OTHERS = {friction.slip_both_ways, integrator.declarations}
"""One only tells, what the other asks is refused before any check (test_what_checks_say.py)."""


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """right(base): the part as it is, made once."""
    return cache(lambda base: subject_of(base, tmp_path_factory.mktemp("right")).make())


@pytest.mark.parametrize("name", some(CATCHES, list(CATCHES)[::3]))
def test_a_check_finds_what_is_planted_for_it(
    name: str, right: Callable[[str], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By itself, and nothing in the part as it was; in plain Python, as formulas are dearer to compile than to run."""
    monkeypatch.setenv("CONTACTLAB_PYTHON", "1")
    check, (base, says) = CHECKS[name.partition(" of ")[0]], CATCHES[name]
    outcome = run_check(check, subject_of(base, tmp_path, changes_of(base, says)).make())
    assert outcome.status == "failed", f"{base}, {says}: not caught"
    assert len(outcome.reason) > 20, "a failure must say what is wrong"
    assert outcome.says.endswith((".", ":"))
    as_it_is = run_check(check, right(base))
    assert as_it_is.status != "failed", as_it_is.reason


def test_every_check_finds_something() -> None:
    assert {CHECKS[name.partition(" of ")[0]] for name in CATCHES} == set(CHECKS.values()) - BY_OTHERS


def test_there_are_enough_of_each() -> None:
    assert len(RIGHT) >= 30
    assert sum(map(len, PLANTED.values())) >= 150


@pytest.mark.parametrize("base", PLANTED)
def test_what_is_exchanged_stands_in_the_part(base: str) -> None:
    for _, *changes in PLANTED[base]:
        assert changed(base, tuple(changes)) != source_of(base)[2]


def test_what_is_not_caught_is_listed_with_a_reason() -> None:
    known = {(base, defect[0]) for base, defects in PLANTED.items() for defect in defects}
    assert set(NOT_CAUGHT) <= known
    assert all(NOT_CAUGHT.values())
