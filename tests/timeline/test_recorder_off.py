"""What nobody records is neither gathered nor paid for."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]


def loaded(scene: Any, folder: Path) -> set[str]:
    """Libraries that a run loads in a process of its own."""
    scene_file = folder / "given.toml"
    scene_file.write_text(scene.toml())
    code = (
        "import sys, contactlab\n"
        f"print(contactlab.simulate(r'{scene_file}', out=r'{folder / 'run'}').status)\n"
        "print(*(name for name in ('h5py', 'rerun', 'pyarrow', 'matplotlib') if name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    status, libraries = done.stdout.split("\n")[:2]
    assert status == "finished"
    return set(libraries.split())


def test_no_library_is_imported_that_no_recorder_needs(small_scene: MakeScene, tmp_path: Path) -> None:
    later = ["vtkhdf", {"use": "rerun", "write": "view"}]
    for name, recorders, expected in (("none", [], set()), ("later", later, {"h5py"})):
        place = tmp_path / name
        place.mkdir()
        assert loaded(small_scene({"record.recorders": recorders}), place) == expected


def test_no_frame_is_built_and_no_step_sampled(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("contactlab.results.journal.frame_of", lambda *_: pytest.fail("a frame was built"))
    monkeypatch.setattr("contactlab.results.steps.StepSampler", lambda *_: pytest.fail("steps were sampled"))
    scene = small_scene({"record.recorders": []})
    assert simulate(scene, tmp_path / "run").status == "finished"
    assert simulate(small_scene()).status == "finished", "without a folder there are no recorders either"
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == [
        "contact.csv", "history.csv", "scene.toml", "summary.json",
    ]  # fmt: skip
