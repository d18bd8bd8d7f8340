"""`contactlab run` that is stopped ends in order, and says in one line how to go on."""

from __future__ import annotations

import json
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import sleep
from typing import Any

import pytest
from tiers import some

import contactlab
from contactlab.cli import main

MakeScene = Callable[..., Any]


@pytest.mark.parametrize("number", some([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_stopped_run_exits_130_and_the_printed_line_goes_on(
    number: signal.Signals, small_scene: MakeScene, tmp_path: Path
) -> None:
    """What a run does on either signal is asked in test_kill.py."""
    # shallow, so that a run this long swings without the contact of so coarse a mesh adding energy
    changes = {"time.end": 2e-5, "record.frames": 50, "supports.1.uy.to": -0.05}
    (tmp_path / "scene.toml").write_text(small_scene(changes).toml())
    folder = tmp_path / "run"
    words = ["run", str(tmp_path / "scene.toml"), "--set", "level=1", "--out", str(folder)]
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab.cli", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    while frames(folder) < 5 and process.poll() is None:
        sleep(0.01)
    process.send_signal(number)
    told, errors = process.communicate()
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["status"] == "interrupted"
    assert f"stopped by {number.name} after step {summary['steps']}" in summary["reason"]
    line = told.splitlines()[-1]
    assert line == f"resume with: contactlab {shlex.join([*words, '--resume'])}"
    assert main(shlex.split(line.partition("contactlab ")[2])) == 0
    results = contactlab.load_results(folder)
    assert results.status == "finished"
    assert results.summary["resumed_at_steps"] == [summary["steps"]]


def frames(folder: Path) -> int:
    path = folder / "history.csv"
    return len(path.read_text().splitlines()) - 1 if path.exists() else 0
