"""What helps at a terminal: completion, one screen of explanation, progress of compilation, JSON, the doctor."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

from contactlab.cli import main
from contactlab.commands import doctor
from contactlab.commands.arguments import SHELLS
from contactlab.run.compiling import compilation_told
from contactlab.run.known_kernels import kernels_of
from contactlab.scene.scene import bundled_scenes, load_scene


def completions(line: str, folder: Path) -> list[str]:
    """What a shell is offered for a line, asked as bash asks."""
    answers = folder / "answers"
    environment = os.environ | {
        "_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "COMP_TYPE": "9",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(answers), "_ARGCOMPLETE_IFS": "\n",
    }  # fmt: skip
    subprocess.run([sys.executable, "-m", "contactlab"], env=environment, cwd=folder, check=False, capture_output=True)
    return answers.read_text().split("\n") if answers.exists() else []


class TestCompletion:
    @pytest.mark.parametrize("shell", SHELLS)
    def test_lines_for_a_shell(self, shell: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["completion", shell]) == 0
        assert "contactlab" in capsys.readouterr().out

    @pytest.mark.parametrize(
        ("line", "offered"),
        [
            ("contactlab expl", "explain "),
            ("contactlab run disc-on", "disc-on-block "),
            ("contactlab parts mortar-p", "mortar-p0"),
            ("contactlab run disc-on-block --set contacts.0.algorithm=node", "contacts.0.algorithm=node-on-segment "),
            ("contactlab run two-bars --set bodies.left.m", "bodies.left.mesh.cells="),
            ("contactlab new-plugin fric", "friction "),
            ("contactlab check coul", "coulomb "),
            ("contactlab compare disc-on-block --reference fin", "finest "),
        ],
    )
    def test_what_is_offered(self, line: str, offered: str, tmp_path: Path) -> None:
        assert offered in completions(line, tmp_path)


def test_as_a_module() -> None:
    done = subprocess.run([sys.executable, "-m", "contactlab", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("contactlab ")


class TestCompilation:
    def test_kernels_are_counted_while_they_are_compiled(self) -> None:
        from contactlab.api.compiled.compiler import COMPILATION

        told: list[str] = []
        scene = load_scene("disc-on-block")
        with compilation_told(scene, told.append):
            for _ in range(2):
                COMPILATION.tell(SimpleNamespace(stats=SimpleNamespace(cache_misses={"a signature": 1})))
            with COMPILATION:
                COMPILATION.tell(None)  # inside another one
        COMPILATION.tell(None)
        total = len(kernels_of(scene))
        assert told == [f"preparing kernel 1 of {total}", f"compiling kernel 2 of {total}"]

    @pytest.mark.parametrize("name", list(bundled_scenes()))
    def test_every_bundled_scene_is_known(self, name: str) -> None:
        assert 5 < len(kernels_of(load_scene(name))) < 80


class TestDoctor:
    def test_for_programs(self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(doctor, "contact_step", lambda registry: (True, "works"))
        assert main(["doctor", "--json"]) == 0
        told = json.loads(capsys.readouterr().out)["facts"]
        facts = {fact["fact"]: fact for fact in told}
        assert len(facts) == len([fact for fact in told if fact["fact"] != "broken plugin"])  # each package once
        for name in ("contactlab", "contactlab-mortar", "numba", "rerun-sdk", "Vulkan driver", "contact step"):
            assert facts[name]["value"]

    def test_every_package_of_an_extra_for_users_is_named(self) -> None:
        written = (Path(__file__).parents[3] / "pyproject.toml").read_text()
        extras = tomllib.loads(written)["project"]["optional-dependencies"]
        brought = {re.split("[<>=]", line)[0]: extra for extra in ("dask", "notebook") for line in extras[extra]}
        assert {name: extra for name, (_, extra) in doctor.OPTIONAL.items()} == brought

    def test_what_is_missing_comes_with_the_way_to_get_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(doctor.OPTIONAL, "no-such-package", ("flying", "wings"))
        fact = next(fact for fact in doctor.optional_packages() if fact.fact == "no-such-package")
        assert fact.value == "not installed: no flying"
        assert "pip install no-such-package" in fact.todo
        assert "contactlab[wings]" in fact.todo

    def test_graphics_drivers_by_their_files(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        for variable in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES"):
            monkeypatch.delenv(variable, raising=False)
        monkeypatch.setattr("platform.system", lambda: "Linux")
        assert "mesa-vulkan-drivers" in doctor.vulkan_driver([str(tmp_path)]).todo
        (tmp_path / "lvp_icd.x86_64.json").write_text("{}")
        monkeypatch.setattr(doctor, "find_library", lambda name: None)
        assert "libvulkan" in doctor.vulkan_driver([str(tmp_path)]).value
        monkeypatch.setattr(doctor, "find_library", lambda name: "libvulkan.so.1")
        assert doctor.vulkan_driver([str(tmp_path)]) == ("Vulkan driver", "lvp (software)", "")
