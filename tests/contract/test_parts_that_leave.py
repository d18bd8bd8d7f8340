"""A part that leaves the program, or crashes it, leaves a summary with the reason and says where."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from contactlab.cli import main
from contactlab.parts.registry import Registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

PARTS = """
import faulthandler
import os
import sys
from dataclasses import dataclass

from contactlab.api.plugin import Part, hookimpl
from contactlab_solids.linear_elastic import LinearElastic

HOW = {"exit": (sys.exit, 3), "leave": (os._exit, 7), "crash": (faulthandler._sigsegv, False)}
calls = []


@dataclass(frozen=True)
class Leaver(LinearElastic):
    how: str = "exit"
    after: int = 0

    def stress(self, gradient, history, dt, stress, new_history):
        calls.append(dt)
        if len(calls) > self.after:
            leave, argument = HOW[self.how]
            leave(argument)
        super().stress(gradient, history, dt, stress, new_history)


@hookimpl
def contactlab_parts():
    return [Part("material", "leaver", "leaving_parts:Leaver", "for tests")]
"""

SCENE = """
name = "left"
time = {{ end = 1e-3 }}
integrator = "central-difference"
record = {{ recorders = [] }}
supports = [{{ on = "slab.bottom", ux = 0.0, uy = 0.0 }}]

[materials.m]
use = "leaver"
how = "{how}"
after = {after}
young = 1000.0
poisson = 0.25
density = 1e-6

[bodies.slab]
element = "q1"
material = "m"
mesh = {{ use = "rectangle", x = [0.0, 1.0], y = [0.0, 1.0], cells = [2, 2] }}
"""


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    file = tmp_path_factory.mktemp("leaving") / "leaving_parts.py"
    file.write_text(PARTS)
    yield file
    sys.modules.pop("leaving_parts", None)


def scene_file(folder: Path, how: str, after: int) -> Path:
    file = folder / "left.toml"
    file.write_text(SCENE.format(how=how, after=after))
    return file


def test_exit_in_a_step_is_a_failed_run(parts: Path, tmp_path: Path) -> None:
    registry = Registry(files=[parts])
    data = scene_file(tmp_path, "exit", 5)
    import leaving_parts  # type: ignore[import-not-found]

    leaving_parts.calls.clear()
    results = simulate(load_scene(data, registry), registry=registry, out=tmp_path / "out")
    assert results.status == "failed"
    assert "leaving_parts.py, line" in results.reason
    assert "in Leaver.stress: the part raised SystemExit: 3" in results.reason
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["reason"] == results.reason


def test_exit_while_building_is_a_wrong_part(parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sys.modules.pop("leaving_parts", None)
    file = scene_file(tmp_path, "exit", 0)
    assert main(["run", str(file), "--with", str(parts), "--out", str(tmp_path / "out")]) == 2
    assert "in Leaver.stress: the part raised SystemExit: 3" in capsys.readouterr().err.replace("\n  ", " ")


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("crash", ["the interpreter crashed (Segmentation fault)", "leaving_parts.py", "in stress"]),
        pytest.param("leave", ["the process ended without a message"], marks=pytest.mark.full),
    ],
)
def test_a_crash_leaves_a_summary_and_says_where(parts: Path, tmp_path: Path, how: str, words: list[str]) -> None:
    file, out = scene_file(tmp_path, how, 5), tmp_path / "out"
    program = [sys.executable, "-m", "contactlab.cli", "run", str(file), "--with", str(parts), "--out", str(out)]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode not in (0, 2)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "failed"
    for word in words:
        assert word in summary["reason"]
        assert word in done.stderr
    assert (out / "crash.txt").exists() == (how == "crash")


def test_nothing_is_left_of_a_sound_run(parts: Path, tmp_path: Path) -> None:
    sys.modules.pop("leaving_parts", None)
    file = scene_file(tmp_path, "exit", 10**9)
    assert main(["run", str(file), "--with", str(parts), "--out", str(tmp_path / "out")]) == 0
    assert not (tmp_path / "out" / "crash.txt").exists()
