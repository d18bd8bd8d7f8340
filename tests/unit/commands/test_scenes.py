"""Bundled scenes on the command line, scenes begun from them, and the schema that editors check them with."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import jsonschema
import meshio
import pytest

from contactlab.cli import main
from contactlab.errors import RequestError
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import bundled_scenes, load_scene
from contactlab.scene.schema import scene_schema


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


class TestPrinted:
    def test_a_scene_is_printed_as_its_file_stands(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["scenes", "stack"]) == 0
        assert capsys.readouterr().out == bundled_scenes()["stack"].read_text()

    def test_for_programs(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["scenes", "--json"]) == 0
        listed = {row["name"]: row for row in json.loads(capsys.readouterr().out)["scenes"]}
        assert listed["disc-on-block"]["contacts"] == ["disc.arc on block.top"]
        assert main(["scenes", "stack", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["scene"]["bodies"] == json.loads(
            json.dumps(load_scene("stack").data["bodies"])
        )

    def test_an_unknown_one(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["scenes", "disk-on-block"]) == 2
        assert 'did you mean "disc-on-block"?' in capsys.readouterr().err


class TestNewScene:
    @pytest.mark.parametrize("source", list(bundled_scenes()))
    def test_a_copy_has_all_comments_and_its_own_name(self, source: str) -> None:
        assert main(["new-scene", "mine", "--from", source]) == 0
        copy, original = Path("mine.toml").read_text(), bundled_scenes()[source].read_text()
        kept = [line for line in original.splitlines() if not line.startswith("name =")]
        assert [line for line in copy.splitlines() if line in kept] == kept
        assert load_scene("mine.toml").data == {**load_scene(source).data, "name": "mine"}

    def test_a_scene_without_a_name(self) -> None:
        text = bundled_scenes()["two-bars"].read_text().replace('name = "two-bars"\n', "")
        Path("nameless.toml").write_text(text)
        assert main(["new-scene", "mine", "--from", "nameless.toml"]) == 0
        assert load_scene("mine.toml").name == "mine"

    @pytest.mark.parametrize("name", ["work/mine", "mine"])
    def test_a_copy_elsewhere_finds_the_files_of_the_first(self, name: str) -> None:
        """Mesh files are named as seen from the folder of the scene; what else has their name stays."""
        for folder in ("first/meshes", "work"):
            Path(folder).mkdir(parents=True)
        corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
        meshio.Mesh(corners, [("quad", [[0, 1, 2, 3]])]).write("first/meshes/cell.vtk")
        text = bundled_scenes()["dropped-block"].read_text()
        source = re.sub(r"mesh = .*", 'mesh = { use = "file", path = "meshes/cell.vtk" } # "meshes" hold it', text)
        Path("first/scene.toml").write_text(source.replace("block.bottom", "block.boundary"))
        assert main(["new-scene", name, "--from", "first/scene.toml"]) == 0
        path = Path(load_scene(f"{name}.toml").bodies["block"].mesh["path"])
        assert path.resolve() == Path("first/meshes/cell.vtk").resolve()
        assert '# "meshes" hold it' in Path(f"{name}.toml").read_text()

    def test_nothing_is_written_over(self, capsys: pytest.CaptureFixture[str]) -> None:
        Path("mine.toml").write_text("precious")
        assert main(["new-scene", "mine", "--from", "two-bars"]) == 2
        assert "exists already" in capsys.readouterr().err
        assert Path("mine.toml").read_text() == "precious"

    @pytest.mark.parametrize("words", [["a b", "--from", "two-bars"], ["mine", "--from", "nothing"]])
    def test_wrong_requests(self, words: list[str]) -> None:
        assert main(["new-scene", *words]) == 2
        assert not list(Path().iterdir())


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft7Validator:
    schema = scene_schema(default_registry())
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


class TestSchema:
    @pytest.mark.parametrize("name", list(bundled_scenes()))
    def test_bundled_scenes_keep_it_as_written_and_written_out(
        self, name: str, validator: jsonschema.Draft7Validator
    ) -> None:
        assert not list(validator.iter_errors(tomllib.loads(bundled_scenes()[name].read_text())))
        assert not list(validator.iter_errors(tomllib.loads(load_scene(name).toml())))

    @pytest.mark.parametrize(
        "changes",
        [
            {"levle": 2},
            {"level": 0},
            {"level": 1.5},
            {"symmetry": "y"},
            {"integrator": "centraldifference"},
            {"integrator": {"us": "central-difference"}},
            {"materials": {"steel": {"use": "neo-hookean", "young": "stiff", "poisson": 0.3, "density": 1.0}}},
            {"materials": {"steel": {"use": "neo-hookean", "poisson": 0.3, "density": 1.0}}},
            {"contacts": [{"slave": "disc.arc", "algorithm": "mortar-p0"}]},
            {"time": {"end": "never"}},
            {"time": {"fraction": 1.5}},
            {"bodies": {"2nd": {}}},
            {"supports": [{"on": "block.bottom", "ux": {"ramp": "jump", "to": 1.0}}]},
        ],
        ids=str,
    )
    def test_what_it_refuses_the_program_refuses(
        self, changes: dict[str, object], validator: jsonschema.Draft7Validator
    ) -> None:
        data = {**tomllib.loads(bundled_scenes()["disc-on-block"].read_text()), **changes}
        assert list(validator.iter_errors(data))
        with pytest.raises(RequestError):
            type(load_scene("disc-on-block")).from_data(data)

    def test_every_key_says_what_it_is(self, validator: jsonschema.Draft7Validator) -> None:
        """Editors show it: also the fields of every part."""
        silent = []
        for name, table in validator.schema["definitions"].items():
            silent += [
                f"{name}.{key}" for key, value in table.get("properties", {}).items() if "description" not in value
            ]
        assert not silent

    def test_it_can_be_printed(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["scenes", "--schema"]) == 0
        assert json.loads(capsys.readouterr().out)["title"] == "contactlab scene"
