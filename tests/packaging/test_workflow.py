"""The workflow for hosted runs does what .ci/run does, on the Pythons of the classifiers; nightly jobs can fail."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]
WORKFLOW: dict[Any, Any] = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))
JOBS = WORKFLOW["jobs"]


def commands(job: str) -> list[str]:
    return [step["run"] for step in JOBS[job]["steps"] if "run" in step]


def test_every_python_of_the_classifiers() -> None:
    classifiers = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["classifiers"]
    promised = [line.rpartition(" ")[2] for line in classifiers if " Python :: 3." in line]
    assert JOBS["test"]["strategy"]["matrix"]["python"] == promised


def test_what_ci_runs_is_run_at_every_push() -> None:
    target = re.search(r"^exec (make \w+)$", (ROOT / ".ci" / "run").read_text(), re.MULTILINE)
    assert target is not None
    assert any(command.startswith(target[1]) for command in commands("test"))
    assert "if" not in JOBS["test"]
    triggers = WORKFLOW[True]  # YAML reads the word "on" as a truth value
    assert {"push", "pull_request", "schedule"} <= set(triggers)


@pytest.mark.parametrize("job", JOBS)
def test_targets_and_files_are_there(job: str) -> None:
    makefile = (ROOT / "Makefile").read_text()
    for command in commands(job):
        for target in re.findall(r"\bmake ([a-z]+)", command):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
        for file in re.findall(r"\b(?:tools|tests)/[\w/]+\.\w+", command):
            assert (ROOT / file).is_file(), file


@pytest.fixture
def tool() -> ModuleType:
    specification = importlib.util.spec_from_file_location("outside_plugins", ROOT / "tools" / "outside_plugins.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_packages_of_others_by_their_names(tool: ModuleType) -> None:
    assert list(tool.packages("# a list\n\ngauss-contact>=0.2\nmy.part[more] # fine\n")) == ["gauss-contact", "my.part"]


def test_a_package_that_is_not_there_fails(
    tool: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "list.txt").write_text("no-such-package\n")
    assert tool.main(tmp_path / "list.txt") == 1
    assert capsys.readouterr().out.splitlines()[-1] == "1 packages of others, failed: no-such-package"
    (tmp_path / "list.txt").write_text("# nobody yet\n")
    assert tool.main(tmp_path / "list.txt") == 0


def test_all_are_tried_and_those_that_fail_are_named(tool: ModuleType) -> None:
    asked = []

    def check(words: list[str]) -> int:
        asked.append(words)
        return {"missing": 2, "wrong": 1}.get(words[1], 0)

    assert tool.failing(["missing", "good", "wrong"], check) == ["missing", "wrong"]
    assert asked == [["check", "missing"], ["check", "good"], ["check", "wrong"]]
