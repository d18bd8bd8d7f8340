"""Measures and references of plugins take part in a comparison with no other change."""

from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import pytest

import contactlab
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.studies.installed_measures import measure_columns

STRANGER = '''
from dataclasses import dataclass
import numpy as np
from contactlab.api import ReferenceSolution, RunMeasure, Scalar, Solution
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Steps(RunMeasure):
    """Steps per millimetre, and how far the pressure in the middle is from that of the reference."""
    title = "middle"
    unit = "share"
    meaning = "Pressure in the middle over that of the reference, less one."

    def evaluate(self, record, contact, reference):
        curve = record.curve(contact)
        return float(np.interp(0.0, curve.x, curve.pressure) / np.interp(0.0, reference.x, reference.pressure) - 1.0)


@dataclass(frozen=True)
class Failing(Steps):
    """It raises."""
    title = "failing"

    def evaluate(self, record, contact, reference):
        raise LookupError("nothing to find")


@dataclass(frozen=True)
class Parabola(ReferenceSolution):
    """What the made-up runs give, but for 1 %."""
    title = "a parabola"
    origin = "made up for a test"

    def mismatch(self, scene):
        return "" if scene["name"] == "parabola" else f"the scene is {scene['name']}"

    def solution(self, scene):
        x = np.linspace(-0.4, 0.4, 401)
        reaction = Scalar(float(scene["level"]) * 50.0, 0.1, "grows with the level, to be told apart")
        return Solution(x, 100.0 * (1.0 - (x / 0.4) ** 2), 0.001, "exact", scalars={"reaction": reaction})


@hookimpl
def contactlab_parts():
    return [
        Part("measure", "middle-error", "measures_of_others:Steps", "m"),
        Part("measure", "failing", "measures_of_others:Failing", "f"),
        Part("reference", "a-parabola", "measures_of_others:Parabola", "r"),
    ]
'''


@pytest.fixture
def registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Registry:
    monkeypatch.delitem(sys.modules, "measures_of_others", raising=False)
    (tmp_path / "measures_of_others.py").write_text(STRANGER)
    return Registry(files=[tmp_path / "measures_of_others.py"])


@pytest.mark.full
@pytest.mark.usefixtures("fake_runs")
def test_they_are_in_the_table_its_files_and_the_report(registry: Registry, tmp_path: Path) -> None:
    """Fake runs give a parabola with 1 % more or less; each is compared with the solution of its own scene."""
    scene = contactlab.load_scene("disc-on-block", registry).with_({"name": "parabola"})
    vary = {"contacts.0.algorithm": ["mortar-p1"], "level": [1, 9]}
    table = contactlab.compare(scene, vary, out=tmp_path / "out", jobs=1, registry=registry)
    first, second = table.rows
    assert (first.reference, second.reference) == ("a-parabola", "a-parabola")
    assert table.reference is not None
    assert table.reference.title == "a parabola"
    assert first["middle_error"] == pytest.approx(-0.01, rel=1e-9)
    assert first["reaction_error"] == pytest.approx(0.0, abs=1e-12)
    assert math.isnan(second["reaction_error"])  # it diverged
    assert math.isnan(first["failing"])
    assert any("nothing to find" in note for note in first.notes)
    assert "middle_error" not in second.measures  # it diverged: nothing is measured
    with (tmp_path / "out" / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["middle_error"]) == first["middle_error"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Pressure in the middle over that of the reference" in page
    assert "made up for a test" in page


def test_a_study_may_name_them(registry: Registry, tmp_path: Path) -> None:
    from contactlab.studies.plan import make_plan

    text = 'scene = "disc-on-block"\nreference = "{}"\nmeasures = ["cpu_s", "{}"]\n'
    study = tmp_path / "study.toml"
    study.write_text(text.format("a-parabola", "middle_error"))
    plan = make_plan(study, registry=registry)
    assert plan.study.measures == ("cpu_s", "middle_error")
    with pytest.raises(RequestError, match="middle_error"):
        make_plan(study)  # where it is not installed
    study.write_text(text.format("a-parabola", "middle-errors"))
    with pytest.raises(RequestError, match='did you mean "middle_error"'):
        make_plan(study, registry=registry)


def test_a_name_of_a_column_that_is_there_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "measures_of_others", raising=False)
    (tmp_path / "measures_of_others.py").write_text(STRANGER.replace('"middle-error"', '"edge-error"'))
    registry = Registry(files=[tmp_path / "measures_of_others.py"])
    with pytest.raises(RequestError, match="every comparison has a column"):
        measure_columns(registry)
