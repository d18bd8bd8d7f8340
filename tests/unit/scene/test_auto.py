"""`integrator = "auto"` as scenes write it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from contactlab.api import Part
from contactlab.errors import PartError, RequestError, SceneError
from contactlab.parts.provenance import part_specs
from contactlab.parts.registry import Registry, default_registry, usual_order
from contactlab.run.attempts import candidates
from contactlab.scene.scene import Scene, load_scene
from contactlab.scene.schema import scene_schema
from contactlab.scene.toml_text import parse_toml

USUAL = ["newton", "implicit-dynamics", "central-difference"]


def scene(integrator: Any) -> Scene:
    return load_scene("disc-on-block").with_({"integrator": integrator})


def test_the_usual_order_is_statics_implicit_dynamics_explicit_steps() -> None:
    found = scene("auto")
    assert [spec["use"] for spec in found.integrator["order"]] == USUAL
    assert found.integrator["order"][0]["tolerance"] == 1e-8  # every default is written out
    assert Scene.from_data(parse_toml(found.toml(), "")).data == found.data
    assert scene({"use": "auto"}).integrator == found.integrator


def test_the_order_and_fields_of_its_integrators_can_be_given_and_changed() -> None:
    found = scene({"use": "auto", "order": ["central-difference", {"use": "newton", "steps": 3}]})
    assert [one.integrator["use"] for one in candidates(found)] == ["central-difference", "newton"]
    changed = found.with_({"integrator.order.1.steps": 5})
    assert [one.integrator.get("steps") for one in candidates(changed)] == [None, 5]
    assert [key for key, kind, _ in part_specs(found) if kind == "integrator"] == [
        "integrator.order.0", "integrator.order.1",
    ]  # fmt: skip
    (alone,) = candidates(found.with_({"integrator": "newton"}))
    assert alone.integrator["use"] == "newton"


@pytest.mark.parametrize(
    ("integrator", "key", "told"),
    [
        ("auot", "integrator", 'did you mean "auto"?'),
        ({"use": "auto", "ordr": []}, "integrator.ordr", 'did you mean "order"?'),
        ({"use": "auto", "steps": 3}, "integrator.steps", "order"),
        ({"use": "auto", "order": []}, "integrator.order", "at least one integrator"),
        ({"use": "auto", "order": ["auto"]}, "integrator.order", "not auto itself"),
        ({"use": "auto", "order": ["newtn"]}, "integrator.order.0", 'did you mean "newton"?'),
        ({"use": "auto", "order": [{"use": "newton", "step": 1}]}, "integrator.order.0.step", 'did you mean "steps"?'),
    ],
)
def test_what_is_wrong_is_named_with_the_nearest_name(integrator: Any, key: str, told: str) -> None:
    with pytest.raises((SceneError, PartError)) as error:
        scene(integrator)
    assert f"key {key} " in str(error.value)
    assert told in str(error.value)


def test_no_part_can_take_the_name() -> None:
    kind = default_registry().part_class("integrator", "newton")
    with pytest.raises(RequestError, match="an integrator cannot be called"):
        Registry([], classes=[(Part("integrator", "auto", "here:Newton", "statics"), kind)])


def test_an_integrator_joins_the_usual_order_by_its_class() -> None:
    newton = default_registry().part_class("integrator", "newton")

    @dataclass(frozen=True)
    class Other(newton):  # type: ignore[misc, valid-type]
        by_default: ClassVar[bool] = True

    assert usual_order(_Kinds({"z": Other, "a": newton, "b": type("No", (newton,), {"by_default": False})})) == [
        "z",
        "a",
    ]


class _Kinds:
    def __init__(self, kinds: dict[str, type]) -> None:
        self.kinds = kinds

    def names(self, kind: str) -> list[str]:
        return list(self.kinds)

    def part_class(self, kind: str, name: str) -> type:
        return self.kinds[name]


def test_the_schema_for_editors_has_it() -> None:
    words, *tables, auto = scene_schema(default_registry())["definitions"]["integrator"]["anyOf"]
    assert set(words["enum"]) == {*default_registry().names("integrator"), "auto"}
    assert auto["properties"]["use"] == {"const": "auto"}
    assert auto["properties"]["order"]["items"]["anyOf"][1:] == tables
