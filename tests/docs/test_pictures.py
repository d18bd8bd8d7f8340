"""No picture in docs is older than what it shows, and changes of either are seen."""

from __future__ import annotations

import importlib
import json
import shutil
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture
def pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The program, which sees a copy of docs."""
    module = importlib.import_module("pictures")
    shutil.copytree(module.DOCS, tmp_path / "docs")
    monkeypatch.setattr(module, "DOCS", tmp_path / "docs")
    monkeypatch.setattr(module, "KEPT", tmp_path / "docs" / "pictures" / "shown.json")
    return module


def test_no_picture_is_older_than_what_it_shows() -> None:
    """One that was made anew is noted by `python benchmarks/studies/pictures.py keep NAME`."""
    assert importlib.import_module("pictures").older() == []


def test_a_picture_of_which_nothing_is_known_is_named(pictures: ModuleType) -> None:
    (pictures.DOCS / "pictures" / "new.png").write_bytes(b"")
    assert pictures.older() == ["pictures/new.png"]


def test_another_picture_is_seen_until_it_is_noted(pictures: ModuleType) -> None:
    with (pictures.DOCS / "pictures" / "accuracy.svg").open("a") as file:
        file.write("<!-- drawn again -->")
    assert pictures.older() == ["pictures/accuracy.svg"]
    pictures.keep(["pictures/accuracy.svg"])
    assert pictures.older() == []


@pytest.mark.parametrize(
    ("page", "old", "new", "seen"),
    [
        ("benchmarks.md", "| 192 | 37.3 |", "| 192 | 38.3 |", "pictures/benchmarks-phases.png"),
        ("look-inside-a-contact.md", "mu=0.2", "mu=0.3", "pictures/timeline-run.png"),
        ("find-the-step.md", "level=1", "level=2", "pictures/chatter-end.png"),
    ],
)
def test_numbers_and_commands_that_change_make_pictures_old(
    page: str, old: str, new: str, seen: str, pictures: ModuleType
) -> None:
    text = (pictures.DOCS / page).read_text()
    assert old in text
    (pictures.DOCS / page).write_text(text.replace(old, new))
    assert seen in pictures.older()


def test_words_around_numbers_may_change(pictures: ModuleType) -> None:
    page = pictures.DOCS / "benchmarks.md"
    page.write_text(page.read_text().replace("| cells | step, µs |", "| number of cells | step, µs |"))
    assert pictures.older() == []


def test_a_figure_of_the_paper_shows_its_numbers(pictures: ModuleType) -> None:
    file = pictures.DOCS / "paper" / "numbers.json"
    numbers = json.loads(file.read_text())
    numbers["f16"]["depth"] = "-"
    file.write_text(json.dumps(numbers))
    assert pictures.older() == pictures.of_figure("f16") == ["paper/figure-16.png", "paper/figure-16-penetration.svg"]
