"""Scenes: defaults, overrides, and text that reads back as the same scene."""

from __future__ import annotations

import pickle
import tomllib
from pathlib import Path

import pytest

import contactlab
from contactlab.errors import Location, PartError, RequestError, SceneError
from contactlab.parts.loading import installed
from contactlab.parts.registry import Registry
from contactlab.scene.fields import keys_of, kind_at
from contactlab.scene.scene import Scene, bundled_scenes, load_scene
from contactlab.testing.scenarios.runs import pressed
from contactlab.testing.subject import Subject


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("disc-on-block")


def test_bundled_scene(scene: Scene) -> None:
    assert scene.name == "disc-on-block"
    assert scene.level == 1
    assert scene.time.end == "auto"
    assert scene.time.fraction == 0.9
    assert scene.bodies["disc"].mesh["cells"] == [24, 6]
    assert scene.bodies["disc"].velocity == (0.0, 0.0)
    assert scene.contacts[0].sides == ("disc.arc", "block.top")
    assert scene.contacts[0].friction is None
    assert scene.supports[1].uy.to == -0.1581
    assert scene.record.frames == 50


@pytest.mark.parametrize("name", bundled_scenes())
def test_a_scene_written_with_all_defaults_reads_back_as_itself(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    path = tmp_path / "scene.toml"
    path.write_text(scene.toml())
    again = load_scene(path)
    assert again == scene
    assert again.data == scene.data
    assert again.toml() == scene.toml()
    assert again.with_({"level": 3}) == scene.with_({"level": 3})


def test_all_keys_with_a_value_are_written(scene: Scene) -> None:
    data = tomllib.loads(scene.toml())
    assert set(keys_of(Scene)) - {"rigid", "fields"} == set(data)  # tables without an entry are left out
    assert set(data["bodies"]["block"]) == {"element", "material", "mesh", "velocity", "spin", "rotate", "shift"}


def test_what_changes_replace_need_not_be_installed(tmp_path: Path) -> None:
    """Scenes, cases and checks that name a mortar are run without it, with the algorithm that is put in its place."""
    without = Registry([point for point in installed() if point.name != "mortar"])
    with pytest.raises(PartError, match="no contact of this name"):
        load_scene("disc-on-block", without)
    scene = load_scene("disc-on-block", without, {"contacts.0.algorithm": "node-on-segment"})
    assert scene.contacts[0].algorithm["use"] == "node-on-segment"
    assert "contacts.0.algorithm" in scene.origin.overrides
    subject = Subject(without, "contact", "node-on-segment")
    assert pressed(subject, "statics").contacts[0].algorithm["use"] == "node-on-segment"
    wrong = tmp_path / "wrong.toml"
    wrong.write_text('integrator = "nothing"\ncontacts = 3\n')
    with pytest.raises(SceneError, match="holds a value"):
        load_scene(wrong, without, {"contacts.tool.algorithm": "barrier"})


def test_data_is_a_copy(scene: Scene) -> None:
    scene.data["bodies"]["disc"]["mesh"]["cells"][0] = 99
    assert scene.bodies["disc"].mesh["cells"] == [24, 6]


def test_a_scene_survives_the_way_to_another_process(scene: Scene) -> None:
    changed = scene.with_({"level": 4})
    assert pickle.loads(pickle.dumps(changed)).data == changed.data


def test_name_defaults_to_the_file(tmp_path: Path, scene: Scene) -> None:
    path = tmp_path / "my-test.toml"
    path.write_text(scene.toml().replace('name = "disc-on-block"\n', ""))
    assert load_scene(path).name == "my-test"
    assert load_scene(str(path)).name == "my-test"


def test_public_name() -> None:
    assert contactlab.load_scene is load_scene


class TestWith:
    """Overrides, as `--set` and `--vary` use them, too."""

    def test_the_original_is_unchanged(self, scene: Scene) -> None:
        before = scene.toml()
        scene.with_({"level": 4, "bodies.disc.mesh.cells": [1, 1]})
        assert scene.toml() == before

    @pytest.mark.parametrize(
        ("key", "value"),
        [
            ("contacts.0.swap", True),
            ("time.fraction", 0.5),
            ("time.step", 1e-9),
            ("time.damping", 10.0),
            ("symmetry", "x"),
            ("bodies.disc.velocity", [0.0, -1.0]),
            ("bodies.disc.shift", [0.0, 0.1]),
            ("bodies.disc.rotate", 30.0),
            ("bodies.disc.mesh.cells", [4, 4]),
            ("materials.soft.young", 1.0),
            ("supports.1.uy.to", -0.01),
            ("supports.1.uy.duration", 1e-4),
            ("record.frames", 3),
            ("level", 7),
        ],
    )
    def test_keys_that_are_written_or_not(self, key: str, value: object, scene: Scene) -> None:
        found = scene.with_({key: value}).data
        for name in key.split("."):
            found = found[int(name)] if isinstance(found, list) else found[name]
        assert found == value

    def test_a_name_reaches_a_contact_and_a_support(self, scene: Scene) -> None:
        named = scene.with_({"contacts.0.name": "tool", "supports.1.name": "press"})
        changed = named.with_({"contacts.tool.swap": True, "supports.press.uy.to": -1.0})
        assert changed == named.with_({"contacts.0.swap": True, "supports.1.uy.to": -1.0})

    @pytest.mark.parametrize("name", ["contacts.0.friction", "contacts.0.friction.use"])
    def test_a_part_that_is_not_there_yet_takes_fields(self, name: str, scene: Scene) -> None:
        changed = scene.with_({"contacts.0.friction.mu": 0.3, name: "coulomb"})
        assert changed == scene.with_({"contacts.0.friction": {"use": "coulomb", "mu": 0.3}})

    def test_another_part_drops_the_fields_of_the_old_one(self, scene: Scene) -> None:
        mesh = scene.with_({"bodies.disc.mesh": {"use": "rectangle", "x": [-1, 1], "y": [0, 1], "cells": [2, 2]}})
        fields = {"x": [-1.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2], "grading": [1.0, 1.0]}
        assert mesh.bodies["disc"].mesh == {"use": "rectangle", **fields}

    def test_fields_that_both_parts_require_stay(self, scene: Scene) -> None:
        linear = scene.with_({"materials.steel.use": "linear-elastic"})
        assert linear.materials["steel"] == {**scene.materials["steel"], "use": "linear-elastic"}

    def test_the_order_of_changes_does_not_matter(self, scene: Scene) -> None:
        changes = {"materials.steel.young": 5.0, "materials.steel.use": "linear-elastic"}
        backwards = dict(reversed(changes.items()))
        assert scene.with_(changes) == scene.with_(backwards)
        assert scene.with_(changes).materials["steel"]["young"] == 5.0

    @pytest.mark.parametrize("value", ["mortar-p1", {"use": "mortar-p1"}])
    def test_a_part_by_name_or_table(self, value: object, scene: Scene) -> None:
        assert scene.with_({"contacts.0.algorithm": value}).contacts[0].algorithm["use"] == "mortar-p1"
        assert scene.with_({"contacts.0.algorithm.use": "mortar-p1"}) == scene.with_({"contacts.0.algorithm": value})

    def test_none_takes_an_optional_part_away(self, scene: Scene) -> None:
        forced = scene.with_({"contacts.0.enforcement": "forward-increment"})
        assert forced.contacts[0].enforcement is not None
        for nothing in ("none", None):
            assert forced.with_({"contacts.0.enforcement": nothing}) == scene

    def test_a_new_entry_of_a_list(self, scene: Scene) -> None:
        more = scene.with_({"supports.2": {"on": "block.left", "ux": 0}})
        assert more.supports[2].ux == 0.0
        bit_by_bit = scene.with_({"supports.2.on": "block.left", "supports.2.ux": 0})
        assert bit_by_bit == more

    def test_no_contacts_at_all(self, scene: Scene) -> None:
        alone = scene.with_({"contacts": []})
        assert alone.contacts == ()
        assert Scene.from_data(tomllib.loads(alone.toml())) == alone

    def test_errors_tell_that_the_value_came_from_outside_the_file(self, scene: Scene) -> None:
        with pytest.raises(SceneError, match="wrong type") as caught:
            scene.with_({"level": "two"})
        assert "bundled scene disc-on-block, key level (set from outside the file)" in str(caught.value)


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("integrator", "integrator"),
        ("materials.steel", "material"),
        ("bodies.disc.mesh", "mesh"),
        ("contacts.0.algorithm", "contact"),
        ("contacts.0.friction", "friction"),
        ("record.recorders.0", "recorder"),
        ("bodies.disc", None),
        ("bodies.disc.mesh.cells", None),
        ("contacts.0", None),
        ("supports.0.uy.to", None),
        ("level", None),
        ("nowhere", None),
        ("materials", None),
    ],
)
def test_which_keys_name_parts(path: str, kind: str | None) -> None:
    assert kind_at(Scene, path.split(".")) == kind


class TestErrors:
    def test_a_message_has_where_got_allowed_and_hint(self) -> None:
        error = RequestError("wrong", where="scene.toml, key a.b", got=[1, True, "x"], allowed="2", hint="2.0")
        assert str(error).splitlines() == [
            "scene.toml, key a.b: wrong",
            '  got      [1, true, "x"]',
            "  allowed  2",
            "  try      2.0",
        ]

    def test_an_error_survives_the_way_to_another_process(self) -> None:
        error = SceneError("wrong", where=Location("f.toml", "a.b", {"a": 3}), got=None, hint="x")
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is SceneError
        assert str(again) == str(error) == "f.toml, line 3, key a.b: wrong\n  got      None\n  try      x"
        assert str(pickle.loads(pickle.dumps(RequestError("plain")))) == "plain"

    def test_the_line_is_that_of_the_innermost_written_table(self) -> None:
        top = Location("f.toml", lines={"a": 3, "a.b": 5})
        assert top.child("a").child("b").child("c").line == 5
        assert top.child("a").child("x").line == 3
        assert top.child("z").line is None
