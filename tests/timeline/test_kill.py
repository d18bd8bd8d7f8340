"""A run that is killed at any moment leaves files that open, loses no stored frame, and can go on exactly."""

from __future__ import annotations

import errno
import json
import os
import random
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.results.checkpoint_slots import Slots
from contactlab.results.journaled import JournaledFile
from contactlab.results.precision import PLACES
from contactlab.results.vtkhdf import VtkHdfRecording
from contactlab.run.simulation import simulate

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="children that are killed are made by fork")

MakeScene = Callable[..., Any]
Assert = Callable[[Any, Any], None]

KILLS = 2
"""Different frames after which a run is killed, of the 20 that `make test FULL=1` makes."""

TRIES = 6
"""Kills for each of them, at most: a loaded machine ends runs early and hits some frames twice."""


class ForkServer:
    """Runs scenes in processes that begin within a millisecond; see fork_server.py."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("fork_server.py"))],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def run(
        self,
        scene: Any,
        folder: Path,
        resume: bool = False,
        lives: float = 0.0,
        largest: int = 0,
        saves: int = 0,
        watch: Callable[[int, int], None] = lambda pid, frames: None,
    ) -> Outcome:
        """Run to the end, for `lives` seconds, or until it has saved its state so often.

        `watch` gets the process and the number of frames so far.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps([scene.toml(), str(folder), resume, lives, largest, saves]) + "\n")
        self.process.stdin.flush()
        told: dict[str, str] = {}
        frames = 0
        for line in self.process.stdout:
            word, _, value = line.strip().partition(" ")
            told[word] = value
            if word == "frame":
                frames += 1
                watch(int(told["pid"]), frames)
            if word == "exit":
                return Outcome(frames, int(value), float(told.get("cpu", "nan")))
        raise AssertionError("the fork server has died")

    def close(self) -> None:
        """End it."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


class Outcome(NamedTuple):
    """Frames reported as stored (without the first), exit status, processor time [s]."""

    frames: int
    status: int
    cpu: float


@pytest.fixture(scope="module")
def fork_server() -> Iterator[ForkServer]:
    made = ForkServer()
    yield made
    made.close()


@pytest.fixture(scope="module")
def scene(small_scene: MakeScene) -> Any:
    return small_scene({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "record.frames": 20})


@pytest.mark.parametrize("kills", [KILLS, pytest.param(20, marks=pytest.mark.full)])
def test_kill_at_random_moments(
    kills: int, scene: Any, fork_server: ForkServer, tmp_path: Path, assert_same_run: Assert, assert_same_files: Assert
) -> None:
    done = fork_server.run(scene, tmp_path / "whole")
    assert done.status == 0
    whole = contactlab.load_results(tmp_path / "whole")
    chance = random.Random(1818)
    seen: set[int] = set()
    for number in range(TRIES * kills):
        folder = tmp_path / f"run-{number}"
        killed = fork_server.run(scene, folder, lives=chance.uniform(0.1, 0.95) * done.cpu)
        if killed.status != -signal.SIGPROF or killed.frames in seen:
            continue
        seen.add(killed.frames)
        check_files(folder, min(killed.frames, len(whole.frames) - 1))  # the end is reported once more
        assert fork_server.run(scene, folder, resume=True).status == 0
        assert_same_run(whole, contactlab.load_results(folder))
        assert_same_files(tmp_path / "whole", folder)
        if len(seen) == kills:
            return
    raise AssertionError(f"{TRIES * kills} kills hit {sorted(seen)} alone, and {kills} frames are asked")


@pytest.mark.full
@pytest.mark.parametrize("saves", [2, 3, 9, 17])
def test_kill_right_after_saving(
    saves: int,
    small_scene: MakeScene,
    fork_server: ForkServer,
    tmp_path: Path,
    assert_same_run: Assert,
    assert_same_files: Assert,
) -> None:
    # a frame is due at every 50th step, when the state is saved, too; the 17th saved state is that of the last step
    scene = small_scene({"time.step": 1e-8, "time.end": 8e-6, "record.frames": 16})
    assert fork_server.run(scene, tmp_path / "whole").status == 0
    whole = contactlab.load_results(tmp_path / "whole")
    assert [frame.step for frame in whole.frames] == list(range(0, 801, 50))
    folder = tmp_path / "killed"
    assert fork_server.run(scene, folder, saves=saves).status == -signal.SIGKILL
    assert fork_server.run(scene, folder, resume=True).status == 0
    resumed = contactlab.load_results(folder)
    assert resumed.summary["resumed_at_steps"] == [50 * (saves - 1)]
    assert_same_run(whole, resumed)
    assert_same_files(tmp_path / "whole", folder)


IMPLICIT = {
    "newton": {"integrator": {"use": "newton", "steps": 10}, "time.end": 1.0, "supports.1.uy.to": -0.02},
    "implicit-dynamics": {"integrator": {"use": "implicit-dynamics", "steps": 40}, "supports.1.uy.to": -0.02},
}


@pytest.mark.parametrize("integrator", some(IMPLICIT, ["newton"]))
def test_each_load_step_is_saved(
    integrator: str, small_scene: MakeScene, fork_server: ForkServer, tmp_path: Path, assert_same_run: Assert
) -> None:
    scene = small_scene(IMPLICIT[integrator])
    assert fork_server.run(scene, tmp_path / "whole").status == 0
    folder = tmp_path / "killed"
    assert fork_server.run(scene, folder, saves=6).status == -signal.SIGKILL
    assert fork_server.run(scene, folder, resume=True).status == 0
    resumed = contactlab.load_results(folder)
    assert resumed.summary["resumed_at_steps"] == [5]
    assert_same_run(contactlab.load_results(tmp_path / "whole"), resumed)


def check_files(folder: Path, frames: int) -> None:
    """As it lies, the file has every frame that was reported, whole, in h5py and in VTK."""
    if frames == 0:
        return  # killed before the file was begun, perhaps
    with h5py.File(folder / "results.vtkhdf") as file:
        count, times = int(file["VTKHDF/Steps"].attrs["NSteps"]), file["VTKHDF/Steps/Values"][:]
    assert count == len(times)
    stored = count
    # frame 0 is stored before any is reported
    assert stored >= frames + 1
    results = contactlab.load_results(folder)
    assert len(results.frames) == stored
    if results.status != "finished":  # killed after its last frame it may be complete
        assert results.status == "interrupted"
        assert "without a message (killed" in results.reason
    for frame in results.frames:
        assert frame.time == times[frame.number]
        assert np.isfinite(frame.displacement).all()
        # the steps that led to a frame are stored with it
        assert frame.step <= len(results.steps["step"])
        curve = frame.curves["contacts.0"]
        at = (results.nodes + frame.displacement)[results.layout.contacts[0].slave_nodes, 0]
        # displacements are below 0.2
        np.testing.assert_allclose(curve.x, at, rtol=0.0, atol=0.25 * 2.0**-PLACES)
    check_vtk(folder / "results.vtkhdf", times)


def check_vtk(path: Path, times: Any) -> None:
    """VTK sees the same times and the same points at the last one."""
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK is not installed (extra: test)")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(times)
    reader.SetStep(len(times) - 1)
    reader.Update()
    grid = reader.GetOutputDataObject(0)
    results = contactlab.load_results(path.parent)
    points = vtk_to_numpy(grid.GetPoints().GetData())[:, :2]
    expected = results.nodes + results.frames[-1].displacement
    # what positions are rounded to, all to the same place, and displacements below 0.2
    np.testing.assert_allclose(points, expected, rtol=0.0, atol=(2.0 * np.abs(points).max() + 0.25) * 2.0**-PLACES)


def test_sigterm_and_ctrl_c_save_the_last_state(scene: Any, fork_server: ForkServer, tmp_path: Path) -> None:
    for number in (signal.SIGTERM, signal.SIGINT):
        folder = tmp_path / number.name

        def stop(pid: int, frames: int, number: signal.Signals = number) -> None:
            if frames == 2:
                os.kill(pid, number)

        assert fork_server.run(scene, folder, watch=stop).status == 130
        results = contactlab.load_results(folder)
        assert results.status == "interrupted"
        assert results.reason.startswith(f"stopped by {number.name} after step {results.summary['steps']}")
        assert len(results.steps["step"]) == results.summary["steps"]


def test_two_runs_cannot_write_to_one_folder(scene: Any, fork_server: ForkServer, tmp_path: Path) -> None:
    refused = []

    def try_too(pid: int, frames: int) -> None:
        if frames == 1:
            os.kill(pid, signal.SIGSTOP)
            with pytest.raises(contactlab.ContactlabError) as error:
                simulate(scene, tmp_path, resume=True)
            refused.append(str(error.value))
            os.kill(pid, signal.SIGCONT)

    assert fork_server.run(scene, tmp_path, watch=try_too).status == 0
    assert "another run is writing to this folder" in refused[0]
    assert contactlab.load_results(tmp_path).status == "finished"


@pytest.mark.parametrize("share", some([0.1, 0.35, 0.6, 0.8, 0.95], [0.6]))
def test_full_disk_keeps_what_was_written(
    share: float,
    small_scene: MakeScene,
    fork_server: ForkServer,
    tmp_path: Path,
    assert_same_run: Assert,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # few frames are asked for, more are stored during the hold: room is made several times
    scene = small_scene({"time.end": "auto", "time.ramp": 1e-6, "time.hold": 2.5e-6, "record.frames": 5})
    assert fork_server.run(scene, tmp_path / "whole").status == 0
    whole = contactlab.load_results(tmp_path / "whole")
    monkeypatch.setattr("contactlab.results.vtkhdf.pack", lambda path: None)  # a file that grows is not compressed
    simulate(scene, tmp_path / "growing")
    folder, size = tmp_path / "full", (tmp_path / "growing/results.vtkhdf").stat().st_size
    stopped = fork_server.run(scene, folder, largest=int(share * size))
    assert stopped.status == 1
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["status"] == "failed"
    assert f"cannot write to {folder}" in summary["reason"]
    assert "file too large" in summary["reason"]
    if (folder / "results.vtkhdf").exists():
        stored = contactlab.load_results(folder)
        assert len(stored.frames) >= stopped.frames + 1
        for frame, expected in zip(stored.frames, whole.frames, strict=False):
            assert np.array_equal(frame.displacement, expected.displacement)
    assert fork_server.run(scene, folder, resume=True).status == 0
    assert_same_run(whole, contactlab.load_results(folder))


@pytest.mark.full
def test_steps_behind_the_last_saved_state_are_made_again(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, assert_same_run: Assert
) -> None:
    """The disk takes no second state, but the steps up to the failure and the summary of it."""
    scene, folder, saved = small_scene({"time.end": 2e-6}), tmp_path / "full", []
    whole = simulate(scene, tmp_path / "whole")
    write = Slots.write

    def once(self: Slots, *given: Any) -> None:
        if saved:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        saved.append(write(self, *given))

    with monkeypatch.context() as patch:
        patch.setattr(Slots, "write", once)
        assert simulate(scene, folder).status == "failed"
    assert len(contactlab.load_results(folder).steps["step"]) > 1
    again = simulate(scene, folder, resume=True)
    assert_same_run(whole, again)
    assert np.array_equal(contactlab.load_results(folder).steps["step"], whole.steps["step"])


@pytest.mark.full
def test_a_disk_that_is_full_at_the_very_end_is_told_once(
    small_scene: MakeScene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    assert_same_run: Assert,
    assert_same_files: Assert,
) -> None:
    """All steps are made and saved; only the summary that is written when the file is closed finds no room."""
    scene, folder = small_scene({"time.end": 2e-6}), tmp_path / "full"
    whole, close = simulate(scene, tmp_path / "whole"), VtkHdfRecording.close

    def no_room(file: JournaledFile) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def close_on_a_full_disk(recording: VtkHdfRecording, summary: Any) -> None:
        with monkeypatch.context() as full:
            full.setattr(JournaledFile, "commit", no_room)
            close(recording, summary)

    with monkeypatch.context() as full, warnings.catch_warnings():
        full.setattr(VtkHdfRecording, "close", close_on_a_full_disk)
        warnings.simplefilter("error")  # the reason of the results says it
        results = simulate(scene, folder)
    assert results.status == json.loads((folder / "summary.json").read_text())["status"] == "failed"
    assert results.summary["steps"] == whole.summary["steps"]
    assert results.reason.count(f"vtkhdf cannot write to {folder}") == 1
    assert "can be resumed when there is space" in results.reason
    resumed = simulate(scene, folder, resume=True)
    assert resumed.status == "finished"
    assert_same_run(whole, resumed)
    assert_same_files(tmp_path / "whole", folder)
