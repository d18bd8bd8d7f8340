"""docs/scene-format.md: its tables are those of the program, its examples are scenes."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

from contactlab.errors import Location
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.study import study_from

ROOT = Path(__file__).parents[2]
DOCUMENT = (ROOT / "docs" / "scene-format.md").read_text()


def _tables() -> ModuleType:
    path = Path(__file__).with_name("scene_tables.py")
    specification = importlib.util.spec_from_file_location("scene_tables", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("heading", "table"), list(_tables().all_tables()), ids=lambda text: text[:20])
def test_every_key_is_documented_as_it_is_read(heading: str, table: str) -> None:
    assert table in DOCUMENT, f"{heading}: run python tests/architecture/scene_tables.py"


def examples(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", DOCUMENT, re.MULTILINE | re.DOTALL)


def whole(example: str) -> dict[str, object] | None:
    """A scene around a part of one."""
    data = tomllib.loads(example)
    if "scene" in data:
        return None
    if "integrator" in data:
        return data
    full = load_scene("disc-on-block").data
    for name, body in data.pop("bodies", {}).items():
        full["bodies"][name] |= body
    if "algorithm" in data:
        full["contacts"][0] |= data
    elif "mesh" in data:
        full["bodies"]["block"] |= data
    else:
        full |= data
    return full


@pytest.mark.parametrize("example", examples("toml"))
def test_examples_are_scenes_or_studies(example: str) -> None:
    data = whole(example)
    if data is None:
        assert len(study_from(tomllib.loads(example), Location("example")).combinations()) > 1
    else:
        assert Scene.from_data(data).bodies


def test_there_are_examples() -> None:
    assert len(examples("toml")) >= 6
    assert len(examples("sh")) >= 1


COMMANDS = [line for example in examples("sh") for line in example.splitlines()]


@pytest.mark.parametrize("line", COMMANDS)
def test_commands_can_be_typed(line: str) -> None:
    from contactlab.commands.arguments import make_parser
    from contactlab.commands.common import parse_settings

    program, *words = shlex.split(line)
    assert program == "contactlab"
    options = make_parser().parse_args(words)
    changes = parse_settings(options.settings)
    changed = load_scene(options.scene).with_(changes).data
    assert changed != load_scene(options.scene).data


@pytest.mark.parametrize("setting", re.findall(r"`--set '?([^'`]+)'?`", DOCUMENT))
def test_settings_in_the_text_work(setting: str) -> None:
    from contactlab.commands.common import parse_settings

    if setting != "KEY=VALUE":
        assert load_scene("disc-on-block").with_(parse_settings([setting]))
