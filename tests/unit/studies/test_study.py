"""Studies say what to run, and wrong ones say what is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from contactlab.errors import RequestError
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.scene import load_scene
from contactlab.studies.plan import make_plan
from contactlab.studies.study import Study, bundled_studies, parse_vary, read_study


def study_file(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text)
    return path


def test_combinations_are_the_product_with_the_first_key_slowest() -> None:
    study = Study(scene="s", vary={"a": (1, 2), "b": ("x", "y", "z")})
    assert [tuple(c.values()) for c in study.combinations()] == [
        (1, "x"), (1, "y"), (1, "z"), (2, "x"), (2, "y"), (2, "z"),
    ]  # fmt: skip


def test_dotted_keys_may_be_quoted_or_nested(tmp_path: Path) -> None:
    path = study_file(tmp_path, 'scene = "disc-on-block"\n[vary]\ncontacts.0.swap = [true]\n"level" = [1, 3]\n')
    assert read_study(path).vary == {"contacts.0.swap": (True,), "level": (1, 3)}


def test_bare_words_are_strings_on_the_command_line() -> None:
    vary = parse_vary(
        ["contacts.0.algorithm=[mortar-p0, mortar-p1]", "level = [1, 2]", 'a.b=[{use="coulomb", mu=0.2}]']
    )
    assert vary == {
        "contacts.0.algorithm": ("mortar-p0", "mortar-p1"),
        "level": (1, 2),
        "a.b": ({"use": "coulomb", "mu": 0.2},),
    }


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (["level"], ["KEY=[V1, V2]", "level"]),
        (["level=2"], ["list", "[2]"]),
        (["level=[]"], ["empty"]),
        (["level=[1, 1]"], ["twice", "repeat"]),
        (["level=[1]", "level=[2]"], ["twice", "--vary level"]),
        (["level=[1"], ["level"]),
    ],
)
def test_a_wrong_vary_says_what_is_allowed(texts: list[str], words: list[str]) -> None:
    with pytest.raises(RequestError) as caught:
        parse_vary(texts)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('scene = "disc-on-block"\nmeasure = []\n', ["measure", "measures", "line 2"]),
        ('scene = "disc-on-block"\nmeasures = ["presure_error"]\n', ["presure_error", "pressure_error", "line 2"]),
        ('scene = "disc-on-block"\nrepeat = 0\n', ["repeat", ">= 1"]),
        ('scene = "disc-on-block"\n[vary]\nlevel = 2\n', ["vary.level", "[2]", "line 3"]),
        ('scene = "disc-on-block"\nvary = 3\n', ["vary", "table"]),
        ('scene = "disc-on-block"\n[pareto]\nlevels = [0]\n', ["pareto.levels", ">= 1"]),
        ('scene = "disc-on-blok"\n[vary]\nlevel = [1]\n', ["disc-on-blok", "disc-on-block"]),
        ('scene = "disc-on-block"\ncontact = "contacts.7"\n[vary]\nlevel = [1]\n', ["contacts.7", "contacts.0"]),
        ('scene = "disc-on-block"\n[vary]\n"contacts.0.swop" = [true]\n', ["swop", "swap"]),
        ('scene = "disc-on-block"\n[vary]\n"contacts.0.algorithm" = ["mortar-p9"]\n', ["mortar-p9", "mortar-p0"]),
    ],
)
def test_a_wrong_study_names_the_key(tmp_path: Path, text: str, words: list[str]) -> None:
    with pytest.raises(RequestError) as caught:
        make_plan(study_file(tmp_path, text))
    for word in words:
        assert word in str(caught.value)


def test_a_scene_beside_the_study_is_found(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(load_scene("disc-on-block").toml())
    plan = make_plan(study_file(tmp_path, 'scene = "own.toml"\n[vary]\nlevel = [1, 2]\n'))
    assert [job.scene.level for job in plan.jobs] == [1, 2]


@pytest.mark.parametrize("name", list(bundled_studies()))
def test_bundled_studies_can_be_planned(name: str) -> None:
    assert make_plan(name).jobs


def test_the_main_study_has_every_algorithm_with_both_slaves_at_three_levels() -> None:
    jobs = make_plan("disc-on-block").jobs
    runs = {(job.algorithm, job.slave, job.scene.level) for job in jobs}
    expected = {
        (algorithm, slave, level)
        for algorithm in ("node-on-segment", "mortar-p0", "mortar-p1")
        for slave in ("disc", "block")
        for level in (1, 2, 4)
    }
    assert runs == expected
    assert len(jobs) == len(expected)
    assert {job.scene.level for job in jobs if not job.refines} == {2}


def test_a_scene_alone_is_run_with_everything_installed() -> None:
    jobs = make_plan(load_scene("disc-on-block")).jobs
    algorithms = {job.algorithm for job in jobs}
    assert algorithms == set(default_registry().names("contact"))
    assert len(jobs) == 2 * len(algorithms)


def test_vary_replaces_the_lists_and_levels_of_a_study() -> None:
    jobs = make_plan("disc-on-block", {"contacts.0.algorithm": ["mortar-p0", "mortar-p1"]}).jobs
    assert [job.algorithm for job in jobs] == ["mortar-p0", "mortar-p1"]


def test_a_changed_key_is_no_longer_varied() -> None:
    plan = make_plan("disc-on-block", changes={"contacts.0.swap": True})
    assert {job.slave for job in plan.jobs} == {"block"}


def test_partners_differ_in_the_swap_alone() -> None:
    plan = make_plan("disc-on-block")
    for job in plan.jobs:
        pair = [other for other in plan.jobs if other.partner == job.partner]
        assert [other.slave for other in pair] == ["disc", "block"]
        assert len({(other.algorithm, other.scene.level) for other in pair}) == 1


FANCY = """
from dataclasses import dataclass
from contactlab.api import GapAlgorithm
from contactlab.api.plugin import Part, hookimpl

@hookimpl
def contactlab_parts():
    return [Part("contact", "fancy", "fancy_part:Fancy", "does nothing")]

@dataclass(frozen=True)
class Fancy(GapAlgorithm):
    passes_patch_test = False
    width: float = 1.0

    def conditions(self, view, *, tangent):
        raise NotImplementedError
"""


def test_fields_of_an_algorithm_that_are_varied_show_in_its_name(tmp_path: Path) -> None:
    (tmp_path / "fancy_part.py").write_text(FANCY)
    registry = Registry(files=[tmp_path / "fancy_part.py"])
    scene = load_scene("disc-on-block", registry)
    whole = {"contacts.0.algorithm": ["fancy", {"use": "fancy", "width": 2.0}]}
    assert [job.algorithm for job in make_plan(scene, whole, registry).jobs] == ["fancy", "fancy width=2.0"]
    field = {"contacts.0.algorithm.width": [3.0, 4.0]}
    base = scene.with_({"contacts.0.algorithm": "fancy"})
    assert [job.algorithm for job in make_plan(base, field, registry).jobs] == ["fancy width=3.0", "fancy width=4.0"]


def test_further_keys_are_told_apart_from_algorithm_slave_and_level() -> None:
    plan = make_plan("disc-on-block", {"level": [1], "contacts.0.swap": [True], "materials.soft.young": [7e3, 8e3]})
    assert [job.choices for job in plan.jobs] == [{"materials.soft.young": 7e3}, {"materials.soft.young": 8e3}]
    assert len({job.name for job in plan.jobs}) == len(plan.jobs)


def test_a_scene_without_contact_cannot_be_compared() -> None:
    scene = load_scene("disc-on-block").with_({"contacts": []})
    with pytest.raises(RequestError, match="no contact to compare"):
        make_plan(scene)
