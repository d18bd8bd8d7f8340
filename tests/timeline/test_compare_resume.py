"""A comparison that was stopped goes on: runs that are over are read back, the others continue where they were."""

from __future__ import annotations

import csv
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import sleep
from typing import Any

import pytest
from inline import runs_inline

import contactlab
from contactlab.cli import main
from contactlab.errors import RequestError
from contactlab.jobs import driver

MakeScene = Callable[..., Any]

# the second run takes three times as long as the first: it is under way when the first has just ended
VARY = {"time.end": [2e-6, 6e-6]}
FILES = ("scene.toml", "history.csv", "contact.csv", "results.vtkhdf", "summary.json", "timeline.rrd")


@pytest.fixture(scope="module")
def stopped(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, str]:
    """Scene, folder and last words of a comparison that was sent SIGTERM in its second run."""
    place = tmp_path_factory.mktemp("comparison")
    scene, folder = place / "scene.toml", place / "out"
    # shallow, so that the long run swings without the contact of so coarse a mesh adding energy
    changes = {"record.recorders": ["vtkhdf", "rerun"], "supports.1.uy.to": -0.05}
    scene.write_text(small_scene(changes).toml())
    command = [sys.executable, "-m", "contactlab.cli", "compare", str(scene), "--jobs", "1", "--out", str(folder)]
    command += [word for key, values in VARY.items() for word in ("--vary", f"{key}={values}")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while frames_of_second(folder) < 2 and process.poll() is None:
        sleep(0.02)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate()
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    return scene, folder, errors.splitlines()[-1]


def frames_of_second(folder: Path) -> int:
    return sum(len(path.read_text().splitlines()) - 1 for path in folder.glob("runs/2-*/history.csv"))


def row_status(folder: Path) -> list[str]:
    with (folder / "table.csv").open(newline="") as file:
        return [row["status"] for row in csv.DictReader(file)]


def stamps(folder: Path) -> dict[str, int]:
    (run,) = folder.glob("runs/1-*")
    return {name: (run / name).stat().st_mtime_ns for name in FILES}


@pytest.mark.full
def test_stopped_comparison_goes_on(stopped: tuple[Path, Path, str], monkeypatch: pytest.MonkeyPatch) -> None:
    scene, folder, line = stopped
    vary = [f"{key}={values}" for key, values in VARY.items()]
    words = [word for text in vary for word in ("--vary", text)]
    expected = shlex.join(
        ["contactlab", "compare", str(scene), "--jobs", "1", *words, "--out", str(folder), "--resume"]
    )
    assert line == f"interrupted; resume with: {expected}"
    assert row_status(folder) == ["finished", "interrupted"]
    assert (folder / "timeline.rrd").exists()
    before = stamps(folder)
    with runs_inline(report=False):
        assert main(shlex.split(expected)[1:]) == 0
    assert stamps(folder) == before, "the run that was over was written again"
    assert row_status(folder) == ["finished", "finished"]
    first, second = (contactlab.load_results(run) for run in sorted(folder.glob("runs/*")))
    assert "resumed_at_steps" not in first.summary
    assert second.summary["resumed_at_steps"][0] > 0

    # once more: nothing is left to do, and nothing is started
    monkeypatch.setattr(driver, "open_pool", lambda *request: pytest.fail("a run was repeated"))
    monkeypatch.setattr("contactlab.comparison.write_report", lambda *_: None)
    again = contactlab.compare(contactlab.load_scene(scene), VARY, out=folder, resume=True)
    assert [row.status for row in again.rows] == ["finished", "finished"]
    assert [row["steps"] for row in again.rows] == [first.summary["steps"], second.summary["steps"]]
    assert again.rows[1].curve == second.contact["contacts.0"].last

    # another request does not go on with these runs
    with pytest.raises(RequestError, match=r"(?s)holds another comparison.*end-2e-06.*end-3e-06"):
        contactlab.compare(contactlab.load_scene(scene), {"time.end": [3e-6, 6e-6]}, out=folder, resume=True)
    with pytest.raises(RequestError, match="holds another comparison"):
        contactlab.compare(contactlab.load_scene(scene), {"level": [1]}, out=folder, resume=True)


def test_resume_needs_a_folder(small_scene: MakeScene) -> None:
    with pytest.raises(RequestError, match="only be resumed in its folder"):
        contactlab.compare(small_scene(), VARY, resume=True)


@pytest.mark.full
def test_repetitions_that_were_made_are_kept(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    submit = driver.Driver._submit

    def counted(self: driver.Driver, waiting: Any) -> None:
        made.append(f"{waiting.run.name} {waiting.run.number}")
        if len(made) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        submit(self, waiting)

    monkeypatch.setattr(driver.Driver, "_submit", counted)
    scene = small_scene()
    request = {"vary": {"contacts.0.algorithm": ["mortar-p0"]}, "out": tmp_path / "out", "repeat": 4, "jobs": 1}
    with pytest.raises(KeyboardInterrupt):
        contactlab.compare(scene, **request)
    numbers = [name.rpartition(" ")[2] for name in made]
    assert numbers == ["0", "1", "2"]
    (row,) = contactlab.compare(scene, **request, resume=True)
    again = [name.rpartition(" ")[2] for name in made[3:]]
    assert again in (["2", "3"], ["3"]), "repetitions were made before"
    assert row.status == "finished"
