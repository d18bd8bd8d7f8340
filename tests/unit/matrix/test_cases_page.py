"""docs/cases.md is what its rows say, and its rows are what an archive says."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import ModuleType

import pytest

from contactlab.archive.archive import FILE, Archive

ROOT = Path(__file__).parents[3]
CHOICES = {
    "case": "patch",
    "variant": "",
    "contact": "mortar-p1",
    "slave": "declared",
    "element": "q1",
    "integrator": "n",
}


@pytest.fixture(scope="module")
def study() -> ModuleType:
    specification = importlib.util.spec_from_file_location(
        "cases_page", ROOT / "benchmarks" / "studies" / "cases_page.py"
    )
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_page_is_not_stale(study: ModuleType) -> None:
    assert study.PAGE.read_text() == study.page(study.stored())


def test_every_installed_case_has_its_numbers(study: ModuleType) -> None:
    from contactlab.parts.registry import default_registry

    shown = {row["case"] for row in study.stored()}
    own = [o.part.name for o in default_registry().parts() if o.origin.distribution == "contactlab-cases"]
    assert {name for name in own if name in default_registry().names("case")} <= shown


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
    (row,) = study.rows_of(tmp_path / FILE)
    assert (row["value"], row["least"], row["verdict"]) == ("2.5", "", "missed")
    assert "**2.5** missed" in study.page([row])
