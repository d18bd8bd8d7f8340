"""Folders that cannot be written to are refused before the first step, with the reason."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from contactlab.errors import RequestError
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]


def test_file_in_the_way(small_scene: MakeScene, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(RequestError, match="no results can be written here: not a directory") as error:
        simulate(small_scene(), tmp_path / "taken" / "run")
    assert str(tmp_path) in str(error.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_folder_without_permission(small_scene: MakeScene, tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    with pytest.raises(RequestError, match="permission denied"):
        simulate(small_scene(), tmp_path)


@pytest.mark.skipif(not Path("/proc/version").exists(), reason="needs a place that takes no files, even from root")
def test_command_says_where_in_one_message() -> None:
    command = [sys.executable, "-m", "contactlab.cli", "run", "disc-on-block", "--out", "/proc/results"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("contactlab: results folder /proc/results: no results can be written here")
    assert "Traceback" not in done.stderr
