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


PROGRAM = """
import sys, contactlab
for folder in sys.argv[1:]:
    print(contactlab.simulate(folder + "/given.toml", out=folder + "/run").status)
    print(*(name for name in ("h5py", "rerun", "pyarrow", "matplotlib") if name in sys.modules))
"""


@pytest.mark.full
def test_no_library_is_imported_that_no_recorder_needs(small_scene: MakeScene, tmp_path: Path) -> None:
    """In a process of its own, which first runs the scene that needs none."""
    folders = []
    for name, recorders in (("none", []), ("later", ["vtkhdf", {"use": "rerun", "write": "view"}])):
        folders.append(tmp_path / name)
        folders[-1].mkdir()
        (folders[-1] / "given.toml").write_text(small_scene({"record.recorders": recorders}).toml())
    command = [sys.executable, "-c", PROGRAM, *map(str, folders)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert [line for line in done.stdout.splitlines() if line != "finished"] == ["", "h5py"]
    assert done.stdout.count("finished") == 2


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
