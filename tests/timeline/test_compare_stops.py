"""A comparison whose runs take too long, hang, or are stopped leaves rows, words, and no process behind."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

import contactlab
from contactlab.comparison import compare
from contactlab.jobs import processes

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="children are found in /proc")

MakeScene = Callable[..., Any]
# a minute and more, without anything happening: the disc stays above the block
LONG = {"time.end": 5e-3, "time.step": 8e-9, "bodies.disc.shift": [0.0, 0.2], "supports.1.uy.to": -0.05}


def children(process: int) -> list[int]:
    """Processes that make runs; not the one that tracks the resources of the others."""
    found = [int(p) for p in Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    for task in Path(f"/proc/{process}/task").iterdir():
        found += [int(p) for p in (task / "children").read_text().split()]
    return sorted(child for child in set(found) if "resource_tracker" not in command_of(child))


def command_of(process: int) -> str:
    try:
        return Path(f"/proc/{process}/cmdline").read_text()
    except OSError:
        return ""


def is_there(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False


@pytest.fixture
def comparison(small_scene: MakeScene, tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start a comparison of two runs that would last for minutes, once both have stored frames."""
    scene, started = tmp_path / "scene.toml", []
    scene.write_text(small_scene({**LONG, "record.frames": 1000}).toml())

    def start(ignores: bool = False) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "contactlab.cli", "compare", str(scene), "--vary"]
        command += ["contacts.0.swap=[false, true]", "--jobs", "2", "--out", str(tmp_path / "out")]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
            preexec_fn=(lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)) if ignores else None,
        )  # fmt: skip
        started.append(process)
        while len(list(tmp_path.glob("out/runs/*/results.vtkhdf"))) < 2 and process.poll() is None:
            sleep(0.02)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.full
def test_a_run_over_its_time_is_a_row_and_can_go_on(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "GRACE", 60.0)  # the machine may be busy
    scene = small_scene({**LONG, "record.frames": 1000})
    for limit in (1.5, 12.0):  # a busy machine may leave no time to build the model
        out = tmp_path / f"out-{limit:g}"
        (row,) = compare(scene, {"contacts.0.swap": [False]}, out=out, jobs=1, time_limit=limit).rows
        assert row.status == "timed-out"
        assert f"time limit of {limit:g} s" in row.reason
        if row["steps"] > 0:
            break
    assert row["steps"] > 0
    (folder,) = (out / "runs").iterdir()
    stored = contactlab.load_results(folder)
    assert stored.status == "interrupted"
    assert stored.summary["steps"] == row["steps"]
    (again,) = compare(scene, {"contacts.0.swap": [False]}, out=out, jobs=1, time_limit=limit, resume=True)
    assert again["steps"] > row["steps"]


@pytest.mark.full
def test_first_ctrl_c_says_what_it_waits_for_and_the_second_ends_all(
    comparison: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    process = comparison()
    workers = children(process.pid)
    assert len(workers) == 2
    os.kill(workers[0], signal.SIGSTOP)
    process.send_signal(signal.SIGINT)
    assert process.stderr is not None
    told = ""
    while "stopping" not in told:
        told = process.stderr.readline()
        assert told, "the program ended without a word"
    assert "Ctrl-C again" in told
    sleep(1.0)
    assert process.poll() is None, "a run that is halted was not waited for"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert [row["status"] for row in rows(tmp_path / "out")] == ["interrupted"] * 2
    assert not any(is_there(worker) for worker in workers)


@pytest.mark.full
def test_started_in_the_background_it_answers_sigterm(
    comparison: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    process = comparison(ignores=True)
    workers = children(process.pid)
    began = monotonic()
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert monotonic() - began < 60.0  # the runs would last longer
    found = rows(tmp_path / "out")
    assert [row["status"] for row in found] == ["interrupted"] * 2
    assert all("its state is saved" in row["reason"] for row in found)
    assert not any(is_there(worker) for worker in workers)
