"""Ranges, samples, keys that go together, and keys of all bodies."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from contactlab.errors import RequestError
from contactlab.scene.scene import load_scene
from contactlab.studies.plan import make_plan
from contactlab.studies.study import parse_vary
from contactlab.studies.vary import combinations


def varied(*texts: str) -> list[dict[str, Any]]:
    return combinations(parse_vary(texts))


def test_ranges_have_their_ends() -> None:
    assert [c["a"] for c in varied("a={linspace=[0.0, 1.0, 5]}")] == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert [c["a"] for c in varied("a={logspace=[0.01, 100.0, 5]}")] == [0.01, 0.1, 1.0, 10.0, 100.0]


def test_ranges_between_whole_numbers_are_whole() -> None:
    assert [type(c["a"]) for c in varied("a={linspace=[1, 3, 3]}")] == [int] * 3
    assert [c["a"] for c in varied("a={logspace=[1, 8, 4]}")] == [1, 2, 4, 8]
    assert [c["a"] for c in varied("a={linspace=[1, 2, 3]}")] == [1.0, 1.5, 2.0]
    assert len(make_plan("disc-on-block", {"level": varied_values("level={linspace=[1, 3, 3]}")}).jobs) == 3


def varied_values(text: str) -> tuple[Any, ...]:
    return next(iter(parse_vary([text]).values()))


def test_a_key_is_not_set_and_varied_at_once() -> None:
    """It was not varied then, in silence."""
    with pytest.raises(RequestError, match="both set and varied"):
        make_plan("disc-on-block", {"level": (1, 2)}, changes={"level": 1})


def test_a_range_under_another_name_is_put_right() -> None:
    with pytest.raises(RequestError) as caught:
        parse_vary(["a={range=[0.0, 1.0, 5]}"])
    assert caught.value.hint == "{ linspace = [0.0, 1.0, 5] }"


def test_keys_that_go_together_are_one_axis() -> None:
    assert varied("a & b=[[1, 10], [2, 20]]", "c=[0, 1]") == [
        {"a": 1, "b": 10, "c": 0}, {"a": 1, "b": 10, "c": 1}, {"a": 2, "b": 20, "c": 0}, {"a": 2, "b": 20, "c": 1},
    ]  # fmt: skip


def test_a_latin_hypercube_has_one_sample_in_each_part_of_each_key() -> None:
    texts = "a={sample=[0.0, 2.0], count=20, seed=3}", "b={sample=[-1.0, 1.0], count=20, seed=3}"
    found = np.array([[c["a"], c["b"]] for c in varied(*texts)])
    for column, least in zip(found.T, (0.0, -1.0), strict=True):
        assert sorted(np.floor((column - least) / 0.1).astype(int)) == list(range(20))
    assert varied(*texts) == varied(*texts)  # the seed decides
    assert varied(*texts) != varied(*(text.replace("seed=3", "seed=4") for text in texts))
    assert abs(np.corrcoef(found.T)[0, 1]) < 0.6  # permuted: 20 pairs of independent numbers exceed 0.6 once in 200


def test_a_star_stands_for_all_bodies() -> None:
    plan = make_plan("disc-on-block", {"bodies.*.element": ("q1", "q2")})
    assert [{str(body["element"]["use"]) for body in job.scene.data["bodies"].values()} for job in plan.jobs] == [
        {"q1"},
        {"q2"},
    ]
    assert [job.choices for job in plan.jobs] == [{"bodies.*.element": "q1"}, {"bodies.*.element": "q2"}]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("a & b=[[1, 10], [2]]", "2 keys go together"),
        ("a={linspace=[0, 1]}", "not a range"),
        ("a={linspace=[0, 1, 1]}", "at least 2 values"),
        ("a={logspace=[0.0, 1.0, 5]}", "same sign"),
        ("a={sample=[1.0, 0.0], count=3}", "not a sample"),
        ("a={sample=[0.0, 1.0]}", "whole numbers"),
        ("a={sample=[0.0, 1.0], count=3, by='sobol'}", "way of sampling"),
    ],
)
def test_wrong_ranges_are_told(text: str, named: str) -> None:
    with pytest.raises(RequestError, match=named):
        parse_vary([text])


def test_a_range_that_is_written_like_a_call_is_put_right() -> None:
    with pytest.raises(RequestError) as caught:
        parse_vary(["a=linspace(0.0, 1.0, 5)"])
    assert caught.value.hint == "{ linspace = [0.0, 1.0, 5] }"
    assert varied(f"a={caught.value.hint}") == varied("a={linspace=[0.0, 1.0, 5]}")


def test_names_of_runs_say_what_varies() -> None:
    scene = load_scene("disc-on-block").with_({"contacts.0.friction": {"use": "coulomb", "mu": 0.1}})
    plan = make_plan(scene, {"contacts.0.friction.mu": (0.1, 0.2), "integrator": ("newton", "central-difference")})
    assert [job.name for job in plan.jobs] == [
        f"{number}-mortar-p0-disc-level-1-mu-{mu}-integrator-{integrator}"
        for number, (mu, integrator) in enumerate(itertools.product((0.1, 0.2), ("newton", "central-difference")), 1)
    ]
    many = make_plan(scene, {f"bodies.{body}.mesh.cells": ([[24, 6]]) for body in ("disc", "block")} | {
        "time.fraction": tuple(0.1 + 0.001 * k for k in range(3)), "materials.steel.young": (70000.0,),
    })  # fmt: skip
    assert all(len(job.name) < 120 for job in many.jobs)
    assert len({job.name for job in many.jobs}) == 3


def test_a_star_over_nothing_is_told() -> None:
    with pytest.raises(RequestError, match="nothing matches"):
        make_plan("disc-on-block", {"rigid.*.uy": (0.0, 1.0)})
