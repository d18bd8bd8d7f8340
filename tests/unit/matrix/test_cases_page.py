"""Pages of measured numbers are built from rows, and the rows of cases are what an archive says."""

from __future__ import annotations

import importlib.util
import itertools
import math
import sqlite3
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from contactlab.jobs.archive import FILE, Archive, StoredRow

ROOT = Path(__file__).parents[3]
CHOICES = {
    "case": "patch",
    "variant": "",
    "contact": "mortar-p1",
    "slave": "declared",
    "element": "q1",
    "integrator": "newton",
}


MORTARS = ("mortar-p0", "mortar-p1", "mortar-dual")
STUDIES = ROOT / "benchmarks" / "studies"


@pytest.fixture(scope="module")
def pages() -> Iterator[ModuleType]:
    """The program that writes all pages with measured numbers."""
    path = list(sys.path)
    specification = importlib.util.spec_from_file_location("pages", STUDIES / "pages.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    yield module
    sys.path[:] = path


@pytest.fixture(scope="module")
def study(pages: ModuleType) -> ModuleType:
    found: ModuleType = pages.cases_page
    return found


def test_no_page_is_stale(pages: ModuleType) -> None:
    """Every number in the prose of docs is what is kept of the runs; pages that are built are nowhere else."""
    assert pages.stale() == []
    assert not [name for name in pages.BUILT if (pages.DOCS / name).exists()]


@pytest.mark.full
def test_all_pages_are_built(pages: ModuleType, tmp_path: Path) -> None:
    pages.build(tmp_path / "docs")
    assert {path.name for path in (tmp_path / "docs").iterdir()} == set(pages.BUILT)
    for path in (tmp_path / "docs").iterdir():
        text = path.read_text()
        assert text.startswith("# "), path.name
        assert "Not run yet" not in text, path.name
        assert "(not measured)" not in text, path.name
        assert "<!-- " not in text, path.name


def test_a_number_that_was_changed_by_hand_is_seen(
    pages: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "docs").mkdir()
    for name in pages.FILLED:
        text = (pages.DOCS / name).read_text()
        last = max(text.rfind(digit, 0, text.find("<!-- end of numbers -->")) for digit in "123456789")
        (tmp_path / "docs" / name).write_text(f"{text[:last]}0{text[last + 1 :]}")
    monkeypatch.setattr(pages, "DOCS", tmp_path / "docs")
    assert pages.stale() == list(pages.FILLED)


def test_a_picture_of_another_run_is_seen(pages: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    demo = pages.demo_page
    assert demo.stale_pictures() == []
    rows = demo.STORED.read_text()
    (tmp_path / "demo.csv").write_text(rows.replace("finished", "diverged", 1))
    monkeypatch.setattr(demo, "STORED", tmp_path / "demo.csv")
    assert demo.stale_pictures() == list(demo.DRAWN.values())


def test_rows_of_the_front_page_are_the_newest_of_the_archive(pages: ModuleType, tmp_path: Path) -> None:
    """Of each algorithm, slave and level; its values may be those of another machine."""
    for machine, key, error in (("there", "old", 0.5), ("here", "old", 0.25), ("here", "other", 0.125)):
        choice = ("mortar-p0", "disc", 1 if key == "old" else 2)
        values = {"pressure_error": error, "cpu_s": 1.5, "steps": 10.0, "level": choice[2]}
        row = StoredRow(key, "disc-on-block", "name", *choice, "finished", "", values, "", machine)
        with Archive(tmp_path / FILE) as archive:
            archive.add_row(row)
    with sqlite3.connect(tmp_path / FILE) as file:
        file.execute("update rows set made = '2000' where machine = 'there'")
    rows = pages.demo_page.rows_of(tmp_path / FILE)
    assert [(row["level"], row["pressure_error"], row["status"]) for row in rows] == [
        ("1", "0.25", "finished"),
        ("2", "0.125", "finished"),
    ]


def test_every_installed_case_has_its_numbers(study: ModuleType) -> None:
    from contactlab.parts.registry import default_registry

    shown = {row["case"] for row in study.stored()}
    own = [o.part.name for o in default_registry().parts() if o.origin.distribution == "contactlab-cases"]
    assert {name for name in own if name in default_registry().names("case")} <= shown


def test_kept_rows_are_of_cells_and_bounds_of_today(pages: ModuleType) -> None:
    """A case that changes its variants, measures or bounds makes its rows stale, until they are measured again."""
    from contactlab.parts.registry import default_registry
    from contactlab.verdicts.plan import Request

    rows, registry = pages.cases_page.case_rows, default_registry()
    cells = rows.asked(Request())
    for key, own in itertools.groupby(pages.cases_page.stored(), rows.key_of):
        measures = cells[key].case(registry).measures(cells[key].setup)
        bounds = {m.name: (m.role, rows.short(m.least), rows.short(m.most)) for m in measures}
        for row in own:
            if row["measure"] in bounds or row["role"] not in ("invariant", ""):
                assert (row["role"], row["least"], row["most"]) == bounds[row["measure"]], (key, row["measure"])


def test_a_folder_with_some_of_the_cases_leaves_the_others(pages: ModuleType) -> None:
    """New rows of a cell stand in place of all that it had; cells that are no longer planned leave."""
    rows = pages.cases_page.case_rows
    old = [{**CHOICES, "measure": name, "value": "1"} for name in ("stress", "displacement")]
    other, gone = ({**CHOICES, "case": name, "measure": "stress", "value": "1"} for name in ("hertz", "a-former-case"))
    new = {**CHOICES, "measure": "stress", "value": "2"}
    wanted = {rows.key_of(new), rows.key_of(other)}
    assert rows.merged([*old, other, gone], [new], wanted) == [other, new]


def test_rows_are_the_newest_of_the_archive(study: ModuleType, tmp_path: Path) -> None:
    bounds = {"least": -math.inf, "most": 1.0, "unit": "", "verdict": "missed", "why": "w"}
    measure = {"measure": "stress", "role": "error", "value": 2.5, **bounds}
    found = {
        "verdict": "missed",
        "status": "finished",
        "reason": "why",
        "cpu_s": 0.0,
        "runs": [],
        "measures": [measure],
    }
    with Archive(tmp_path / FILE) as archive:
        archive.add_cell("a", "here", CHOICES, found)
        archive.add_cell("b", "here", CHOICES | {"slave": "exchanged"}, found)  # no cell of the quick matrix
    (row,) = study.rows_of(tmp_path / FILE)
    assert (row["value"], row["least"], row["verdict"]) == ("2.5", "", "missed")
    assert "**2.5** missed" in study.page([row])


def test_cells_of_the_full_matrix_without_an_answer_are_listed_with_their_cause(pages: ModuleType) -> None:
    """Of 1000 cells and more; a kind that is no longer there leaves the list, and no mortar is silent."""
    full = pages.full_page
    rows = full.stored()
    assert len(rows) >= 1000
    assert set(full.unanswered(rows)) == set(full.CAUSES)
    assert not {r["case"] for r in rows if r["verdict"] == "silent" and r["contact"] in MORTARS}
    assert {row["slave"] for row in rows} == {"declared", "exchanged"}
    assert len({row["integrator"] for row in rows}) == 3
