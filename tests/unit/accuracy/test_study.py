"""Studies of cases: what they ask, and one that is run, resumed and written."""

from __future__ import annotations

import csv
import re
from collections.abc import Generator, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from inline import runs_inline

from contactlab.accuracy import run
from contactlab.accuracy.point import Point, Task, named, point_plan
from contactlab.accuracy.problem import choices, contenders, problem_of
from contactlab.accuracy.run import GROWTH, Budget, LineTasks, expected_cost, line_plan, plan
from contactlab.accuracy.study import CaseChoice, Contender, find_case_study
from contactlab.api import Potential, Setup
from contactlab.cli import main
from contactlab.errors import RequestError
from contactlab.jobs.run import here
from contactlab.parts.registry import Registry, default_registry
from contactlab.studies.reference import load_reference

TINY = """
levels = [1]
join = false
cases = [{ use = "shrink-fit", error = "mean pressure" }]
contenders = [{ way = "statics", algorithm = "mortar-p1", element = "q1", integrator = "newton" }]
"""


@pytest.fixture(autouse=True, scope="module")
def inline() -> Iterator[None]:
    with runs_inline():
        yield


@pytest.mark.full  # plans a thousand runs
def test_the_bundled_study_is_as_large_as_it_says() -> None:
    study = find_case_study("accuracy")
    assert study is not None
    asked, lines = plan(study, default_registry())
    assert len(asked) >= 10
    assert sum(a.reference == "exact" for a in asked) >= 6
    assert len(contenders(study, default_registry())) >= 10
    assert sum(len(line.tasks) for line in lines) >= 1000
    assert 0 < len(plan(study.quickened(), default_registry())[1]) < len(lines) / 3


def test_the_demo_begins_with_statics() -> None:
    study = find_case_study("demo")
    assert study is not None
    asked, lines = plan(study, default_registry())
    assert len(asked) == 1
    levels = {line.tasks[0].contender.label: [task.level for task in line.tasks] for line in lines}
    classes = [default_registry().part_class("contact", name) for name in default_registry().names("contact")]
    assert len(levels) == sum(1 if issubclass(cls, Potential) else 2 for cls in classes)
    assert all(found == ([1, 2] if name.endswith("explicit") else [1, 2, 3, 4]) for name, found in levels.items())
    for line in lines:  # level 2 of statics comes before level 1 of explicit runs
        assert (line.place(line.tasks[1], 0.0) < (1, 1)) == (line.tasks[0].contender.way == "statics")


def test_parts_of_a_file_join(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "from contactlab.api.plugin import Part, hookimpl\n"
        "from contactlab_cases.hertz import Hertz\n"
        "from contactlab_mortar.mortar import MortarP1\n"
        "from dataclasses import dataclass\n"
        "@dataclass(frozen=True)\n"
        "class MyCase(Hertz): pass\n"
        "@dataclass(frozen=True)\n"
        "class MyContact(MortarP1): pass\n"
        "@hookimpl\n"
        "def contactlab_parts():\n"
        "    both = ('case', 'my-case', 'MyCase'), ('contact', 'my-contact', 'MyContact')\n"
        "    return [Part(kind, name, f'mine:{target}', 'mine') for kind, name, target in both]\n"
    )
    registry = Registry(files=[str(file)])
    study = find_case_study("accuracy")
    assert study is not None
    assert "my-case" in [choice.label for choice in choices(study, registry)]
    assert "my-contact q1 explicit" in [contender.label for contender in contenders(study, registry)]


def test_errors_are_relative_whatever_a_case_measures() -> None:
    registry, setup = default_registry(), Setup("mortar-p0", False, "q1", "central-difference")
    bars = problem_of(CaseChoice(use="two-bars", error="force per height"), registry)
    assert bars.error(setup, {"force per height": 14.85}) == pytest.approx(0.01)  # rho c v/2 is 15
    drawn = problem_of(CaseChoice(use="ironing", error="end of press", answer=310.0, uncertainty=1e-3), registry)
    assert drawn.error(setup, {"end of press": 313.1}) == pytest.approx(0.01)
    assert drawn.uncertainty(setup) == 1e-3
    hertz = problem_of(CaseChoice(use="hertz"), registry)
    assert hertz.measure(setup).name == "L2 of the pressure"
    assert hertz.error(setup, {"L2 of the pressure": -0.02}) == 0.02


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("mean pressure", "mean presure", "mean pressure"),
        ("shrink-fit", "shrink-it", "shrink-fit"),
        ("way =", "away =", "way"),
    ],
)
def test_wrong_studies_are_told(tmp_path: Path, old: str, new: str, named: str) -> None:
    (tmp_path / "tiny.toml").write_text(TINY.replace(old, new))
    with pytest.raises(RequestError, match=re.escape(named)):
        _planned(str(tmp_path / "tiny.toml"))


def _planned(path: str) -> None:
    study = find_case_study(path)
    assert study is not None
    plan(study, default_registry())


def test_a_study_is_run_once_and_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tiny.toml").write_text(TINY)
    words = ["compare", str(tmp_path / "tiny.toml"), "--out", str(tmp_path / "out"), "--jobs", "1"]
    assert main(words) == 0
    with (tmp_path / "out" / "accuracy.csv").open() as file:
        first = list(csv.DictReader(file))
    assert [row["status"] for row in first] == ["finished"] * 2
    # Lame's pressure within 1 % on eight cells across each ring, as the case allows
    assert all(0.0 < float(row["error"]) < 0.01 and float(row["cpu_s"]) > 0.0 for row in first)
    page = (tmp_path / "out" / "accuracy.html").read_text()
    assert "shrink-fit" in page
    own = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)  # the plot library's text names its home page
    assert not re.search(r'(src|href)="(https?:)?//', own)  # it asks nobody for anything
    assert "<script src" not in page
    monkeypatch.setattr("contactlab.reports.accuracy_page.write_accuracy_page", lambda *_, **__: None)
    assert main([*words, "--resume"]) == 0
    with (tmp_path / "out" / "accuracy.csv").open() as file:
        assert list(csv.DictReader(file)) == first  # times and all: nothing was run again
    capsys.readouterr()


def test_no_point_is_as_fine_as_the_runs_of_its_reference() -> None:
    level = load_reference("disc-on-block-deep").level
    assert level is not None
    choice = CaseChoice(scene="disc-on-block", reference="disc-on-block-deep")
    task = Task(choice, Contender("", "q1", "newton", "mortar-p0"), False, level, 1.0)
    problem = problem_of(choice, default_registry())
    point = here(point_plan(task, problem, default_registry()), lambda run: pytest.fail("it was run"))
    assert point.status == "not-applicable"
    assert f"level {level}" in point.reason


def test_the_example_of_the_page_is_a_study(tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "docs" / "accuracy.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```toml\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    (tmp_path / "mine.toml").write_text(example)
    _planned(str(tmp_path / "mine.toml"))


def test_what_should_cost_least_comes_first() -> None:
    bundled = find_case_study("accuracy")
    assert bundled is not None
    study = replace(bundled, cases=(bundled.cases[0],), levels=(1, 2, 4))
    first, second = plan(study, default_registry())[1][:2]
    assert place(first, []) == place(second, []) == (0, 0.0)  # nothing is known of either
    slow, fast = [point(first.tasks[0], 0.5)], [point(second.tasks[0], 0.2)]
    assert place(first, slow) == (0, pytest.approx(0.5 * 2.0**GROWTH))
    assert place(second, fast) < place(first, slow)


def place(line: LineTasks, done: list[Point]) -> tuple[float, float]:
    task = line.tasks[len(done)]
    return line.place(task, expected_cost(done, task.level))


@pytest.mark.parametrize(
    ("cost", "budget", "expected"),
    [
        (10.0, None, ["finished", "over-limit", "over-limit"]),
        (1.0, 8.0, ["finished", "over-budget", "over-limit"]),
        (0.1, 8.0, ["finished", "finished", "finished"]),
    ],
)
def test_a_level_beyond_the_limit_or_the_budget_is_not_run(
    cost: float, budget: float | None, expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Costs grow with the cube of the level, the limit is 30 s."""

    def point_plan(task: Task, *rest: Any) -> Generator[list[Any], Any, Point]:
        why = rest[-1]()
        yield []
        now = cost * task.level**3
        return named(task, "over-budget", why) if why else replace(point(task, now), spent=now)

    monkeypatch.setattr(run, "point_plan", point_plan)
    bundled = find_case_study("accuracy")
    assert bundled is not None
    study = replace(bundled, cases=(bundled.cases[0],), levels=(1, 2, 4), limit=30.0)
    line = plan(study, default_registry())[1][0]
    told: list[Point] = []
    found = here(line_plan(line, default_registry(), Budget(budget), told.append), lambda run: pytest.fail("a run"))
    assert [one.status for one in told] == expected
    assert found == told


def test_levels_behind_one_that_was_stopped_were_stopped_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are not beyond the limit: nobody knows what they take."""

    def point_plan(task: Task, *rest: Any) -> Generator[list[Any], Any, Point]:
        yield []
        return point(task, 1.0) if task.level == 1 else named(task, "interrupted", "stopped before it began")

    monkeypatch.setattr(run, "point_plan", point_plan)
    bundled = find_case_study("accuracy")
    assert bundled is not None
    study = replace(bundled, cases=(bundled.cases[0],), levels=(1, 2, 16), limit=30.0)
    line = plan(study, default_registry())[1][0]
    found = here(line_plan(line, default_registry(), Budget(None), lambda _: None), lambda run: pytest.fail("a run"))
    assert [one.status for one in found] == ["finished", "interrupted", "interrupted"]


def point(task: Task, cost: float) -> Point:
    return replace(named(task, "finished", ""), error=0.1, cpu=(cost,))
