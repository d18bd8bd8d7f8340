"""Planted defects: a tenth of them is found by the check, and every one still fits the sources (see `make mutants`)."""

from __future__ import annotations

from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest
from mutants import PAGE, module_of, planted, verdict
from mutations import MUTATIONS

from contactlab.api.part import KINDS
from contactlab.parts.registry import default_registry

EVERY = 22  # of the mutants, over all kinds
SLOW = {"integrator", "contact", "watch"}  # whose checks run steps

OF_FORMULAS = [number for number, m in enumerate(MUTATIONS) if m.part in ("mortar-dual", "gauss-point")]


def cheap() -> list[int]:
    """A twentieth of all mutants, spread over the kinds whose checks are quick."""
    missed = PAGE.read_text(encoding="utf-8")
    quick = [
        number for number, m in enumerate(MUTATIONS)
        if m.kind not in SLOW and f"- {m.kind} `{m.part}`, {m.says}\n" not in missed
    ]  # fmt: skip
    return quick[3::EVERY][: len(MUTATIONS) // 10 + 1]


def test_there_are_enough_of_every_kind() -> None:
    counts = Counter(mutation.kind for mutation in MUTATIONS)
    assert set(counts) == set(KINDS)
    assert min(counts.values()) >= 10
    assert len(MUTATIONS) >= 100


@pytest.mark.parametrize("number", range(len(MUTATIONS)))
def test_what_is_exchanged_stands_in_the_source(number: int) -> None:
    mutation = MUTATIONS[number]
    path = Path(str(import_module(module_of(mutation)).__file__))
    assert mutation.old in path.read_text(encoding="utf-8")
    assert mutation.new != mutation.old


@pytest.mark.parametrize("number", cheap())
def test_a_planted_defect_is_found(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    found = verdict(MUTATIONS[number], number, tmp_path)
    assert found.check, f"{MUTATIONS[number].says}: not caught"
    assert len(found.reason) > 20, "a failure must say what is wrong"


@pytest.mark.parametrize(
    "number", [n if k % 16 == 0 else pytest.param(n, marks=pytest.mark.full) for k, n in enumerate(OF_FORMULAS)]
)
def test_a_defect_of_a_formula_is_found(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In plain Python: kernels of a class that is checked once are dearer to compile than to run."""
    monkeypatch.setenv("CONTACTLAB_PYTHON", "1")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert verdict(MUTATIONS[number], number, tmp_path).check, f"{MUTATIONS[number].says}: not caught"


def test_a_mutant_is_the_part_with_one_thing_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    number = next(n for n, m in enumerate(MUTATIONS) if m.kind == "friction" and m.says == "ignores mu")
    subject = planted(MUTATIONS[number], number, tmp_path)
    assert subject.make().bound().coefficient == 0.2
    shipped = default_registry().make("friction", {"use": MUTATIONS[number].part, "mu": 0.7})
    assert shipped.bound().coefficient == 0.7


def test_the_page_says_what_is_caught() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert f"Of {len(MUTATIONS)} mutants `contactlab check` fails" in text
