"""`contactlab view`: errors for people, and pictures without a display."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

from contactlab.api.drawing.colours import STYLES, rgb, styles
from contactlab.cli import main
from contactlab.commands.view import recording_in
from contactlab.parts.registry import default_registry
from contactlab.results.result_file import FILE as STORED
from contactlab.run.simulation import simulate
from contactlab.studies.recordings import left_out, record_comparison

viewer = pytest.importorskip("contactlab_rerun.viewer", reason="plugin contactlab-rerun is not installed")
pytest.importorskip("rerun.experimental", reason="rerun-sdk is not installed (plugin contactlab-rerun)")

MakeScene = Callable[..., Any]
ALGORITHMS = ("node-on-segment", "mortar-p0", "mortar-p1")


@pytest.fixture(scope="module")
def comparison(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a comparison on the disc on a block: three algorithms."""
    folder = tmp_path_factory.mktemp("comparison")
    for number, algorithm in enumerate(ALGORITHMS):
        # shallow: nodes on segments of so coarse a mesh make energy with frozen forces
        changes = {"contacts.0.algorithm": algorithm, "supports.1.uy.to": -0.05}
        simulate(small_scene(changes), folder / "runs" / str(number))
    scene = small_scene({"record.recorders": ["vtkhdf", "rerun"]})
    names = [str(number) for number in range(len(ALGORITHMS))]
    record_comparison(scene, default_registry(), folder, names, for_good=True)
    return folder


def needs_driver(work: Callable[[], Any]) -> Any:
    """The result of `work`, or a skipped test where no graphics driver is there, not even one in software."""
    try:
        return work()
    except RuntimeError as error:
        if str(error) == viewer.NO_DRIVER:
            pytest.skip(str(error))
        raise


def pixels(png: Path) -> np.ndarray:
    """Colours (height, width, 3)."""
    from PIL import Image

    with Image.open(png) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def share_of(colour: str, picture: np.ndarray) -> float:
    """Share of pixels that have this colour, but for what a palette of 256 colours changes (24 of 255)."""
    return float((np.abs(picture - np.array(rgb(colour))).max(axis=2) <= 24).mean())


# --- pictures -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def late(comparison: Path, tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    """Step 500, where the bodies are loaded."""
    return drawn(comparison, tmp_path_factory.mktemp("late") / "late.png", 500)


def drawn(comparison: Path, png: Path, step: int) -> np.ndarray:
    """Colours of the whole view."""
    recorder = default_registry().make("recorder", "rerun")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # views that could not be drawn are warned of
        needs_driver(lambda: recorder.show(comparison / recorder.shown_file, png, step))
    return pixels(png)


@pytest.mark.full
def test_picture_of_a_comparison_shows_every_algorithm_in_its_colour(
    comparison: Path, late: np.ndarray, tmp_path: Path
) -> None:
    early = drawn(comparison, tmp_path / "early.png", 10)
    assert late.shape == (964, 1600, 3)
    assert len(np.unique(late.reshape(-1, 3), axis=0)) > 100, "the picture is blank"
    chosen = styles(ALGORITHMS)
    # outlines and curves: lines of two pixels, some thousand of them
    for algorithm in ALGORITHMS:
        assert share_of(chosen[algorithm].colour, late) > 1e-3, algorithm
    unused = {style.colour for style in STYLES} - {style.colour for style in chosen.values()}
    assert all(share_of(colour, late) < 5e-4 for colour in unused)
    # the bodies grow lighter under load: the upper part of the picture holds the meshes
    assert (np.abs(early - late).max(axis=2) > 30).mean() > 0.01
    assert early[:400].sum() < late[:400].sum()


@pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(), reason="sockets are looked up in /proc")
def test_viewer_listens_on_this_machine_alone_and_ends(comparison: Path) -> None:
    def view() -> None:
        children = set(children_of(os.getpid()))
        with viewer.headless_viewer(comparison / "timeline.rrd") as client:
            (process,) = set(children_of(os.getpid())) - children
            viewer._wait_for(client)
            addresses = listening(process)
            assert addresses
            assert {address for address, _ in addresses} == {"0100007F"}, "not 127.0.0.1 (hexadecimal, reversed)"
            names: set[str] = set()
            until = monotonic() + 30.0
            while not set(ALGORITHMS) <= names and monotonic() < until:  # views come one by one on a busy machine
                names = {view.name for view in client.get_state().views}
                sleep(0.1)
            assert set(ALGORITHMS) <= names
        assert process not in children_of(os.getpid())

    needs_driver(view)


def children_of(process: int) -> list[int]:
    text = Path(f"/proc/{process}/task/{process}/children").read_text()
    return [int(word) for word in text.split()]


def listening(process: int) -> set[tuple[str, str]]:
    """Address and port of every TCP socket on which the process waits for others."""
    targets = {str(path.readlink()) for path in Path(f"/proc/{process}/fd").iterdir() if path.is_symlink()}
    found = set()
    for name in ("tcp", "tcp6"):
        for line in Path(f"/proc/{process}/net/{name}").read_text().splitlines()[1:]:
            words = line.split()
            if words[3] == "0A" and f"socket:[{words[9]}]" in targets:
                address, _, port = words[1].partition(":")
                found.add((address, port))
    return found


def test_window_is_bound_to_this_machine(monkeypatch: pytest.MonkeyPatch, comparison: Path) -> None:
    started: list[list[str]] = []

    class Process:
        returncode = None

        def __init__(self, command: list[str], **options: Any) -> None:
            started.append(command)

        def communicate(self, timeout: float) -> None:
            raise subprocess.TimeoutExpired("rerun", timeout)

    monkeypatch.setattr(viewer.subprocess, "Popen", Process)
    assert main(["view", str(comparison)]) == 0
    (command,) = started
    assert command[command.index("--bind") + 1] == "127.0.0.1"
    assert command[-1] == str(comparison / "timeline.rrd")


def test_killed_run_is_shown_as_far_as_it_came(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its recording is made from the results file, and made anew when the run has gone on."""
    shown: list[float] = []
    monkeypatch.setattr("contactlab_rerun.viewer.open_window", lambda file: shown.append(file.stat().st_size))
    simulate(small_scene({"record.recorders": ["vtkhdf"]}), tmp_path)
    assert main(["view", str(tmp_path)]) == 0
    assert shown[0] > 10_000
    made = (tmp_path / "timeline.rrd").stat().st_mtime_ns
    assert main(["view", str(tmp_path)]) == 0
    assert (tmp_path / "timeline.rrd").stat().st_mtime_ns == made, "what is there is not made again"


# --- wrong requests -------------------------------------------------------------------------------


@pytest.mark.parametrize(("words", "expected"), [
    (["nowhere"], "nowhere: there is no such file or folder"),
    (["empty"], "the folder holds no results"),
    (["{runs}", "--step", "3"], "--step: a step is for pictures"),
    (["{runs}", "--png", "a.jpg"], 'pictures are PNG files got "a.jpg"'),
    (["{runs}", "--png", "no/where/a.png"], "there is no such folder"),
])  # fmt: skip
def test_wrong_requests(
    words: list[str], expected: str, comparison: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    assert main(["view", *(word.format(runs=comparison) for word in words)]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert expected in error, error


def test_step_that_is_not_there(comparison: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["view", str(comparison), "--png", str(tmp_path / "a.png"), "--step", "1000000"])
    error = capsys.readouterr().err
    if viewer.NO_DRIVER in error:
        pytest.skip(viewer.NO_DRIVER)
    assert status == 2
    assert "step: got 1000000, allowed: 0 to " in error
    assert not (tmp_path / "a.png").exists()


def test_missing_driver_names_the_package(
    comparison: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A viewer that dies as it does without a driver."""
    program = tmp_path / "rerun"
    program.write_text(
        f"#!{sys.executable}\nimport sys; sys.stderr.write('Failed to get render context'); sys.exit(102)"
    )
    program.chmod(0o755)
    monkeypatch.setattr(viewer, "_program", lambda: [str(program)])
    assert main(["view", str(comparison), "--png", str(tmp_path / "a.png")]) == 1
    assert "mesa-vulkan-drivers" in capsys.readouterr().err


def test_file_that_is_no_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "timeline.rrd"
    file.write_text("nothing of a recording")
    assert main(["view", str(file)]) == 2
    assert f"contactlab: {file}: the file is not a recording" in capsys.readouterr().err


def test_finer_runs_of_a_comparison_are_left_out(tmp_path: Path) -> None:
    """They are there for the plot of error against cost; side by side they would hide the others."""
    import json

    from contactlab.studies.recordings import main_runs_of

    rows = [{"name": "1-coarse", "refines": False}, {"name": "2-fine", "refines": True}]
    (tmp_path / "table.json").write_text(json.dumps({"rows": [{**row, "algorithm": "mortar-p0"} for row in rows]}))
    for row in rows:
        place = tmp_path / "runs" / str(row["name"])
        place.mkdir(parents=True)
        (place / STORED).touch()
    assert main_runs_of(tmp_path) == ["1-coarse"]


def test_runs_of_a_comparison_are_chosen_by_name(
    comparison: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorder = default_registry().make("recorder", "rerun")
    whole = (comparison / recorder.shown_file).read_bytes()
    file = recording_in(comparison, recorder, ["2", "0"])
    assert file == comparison / "chosen" / recorder.shown_file
    assert b"mortar-p1" in file.read_bytes()
    assert b"mortar-p0" not in file.read_bytes()
    assert (comparison / recorder.shown_file).read_bytes() == whole
    assert main(["view", str(comparison), "--runs", "3", "--png", str(tmp_path / "no.png")]) == 2
    assert "the comparison has no such run" in capsys.readouterr().err
    assert main(["view", str(comparison / "runs" / "0"), "--runs", "0", "--png", str(tmp_path / "no.png")]) == 2
    assert "--runs needs a comparison" in capsys.readouterr().err


def test_a_panel_that_is_not_there(comparison: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = comparison / "runs" / "0"
    assert main(["view", str(run), "--panel", "nothing", "--png", str(run / "a.png")]) == 2
    assert "--panel: no panel has nothing in its name; allowed: disc-on-block" in capsys.readouterr().err
    assert not (run / "panel").exists()
    assert main(["view", str(run / "timeline.rrd"), "--panel", "energy", "--png", str(run / "a.png")]) == 2
    assert "--panel needs results" in capsys.readouterr().err


@pytest.mark.full
def test_a_picture_of_one_panel(comparison: Path, late: np.ndarray, tmp_path: Path) -> None:
    png = tmp_path / "energy.png"
    assert main(["view", str(comparison), "--png", str(png), "--panel", "internal energy"]) == 0
    energy = pixels(png)
    assert energy.shape == late.shape
    # curves on an empty ground, of which meshes and other panels leave less
    seen, alone = (
        np.unique(p.reshape(-1, 3), axis=0, return_counts=True)[1].max() / p[..., 0].size for p in (late, energy)
    )
    assert max(seen, 0.9) < alone < 1.0


def test_a_folder_of_many_runs_shows_the_first_of_each_algorithm(
    comparison: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs side by side in a folder that no comparison made; the scene of each tells its algorithm."""
    for number in range(15):
        shutil.copytree(comparison / "runs" / str(number % 3), tmp_path / f"run-{number:02d}")
    recorder = default_registry().make("recorder", "rerun")
    shown: list[list[str]] = []
    monkeypatch.setattr(type(recorder), "compared", lambda self, folder, runs: shown.append(list(runs)))
    file = recording_in(tmp_path, recorder)
    assert file == tmp_path / "chosen" / recorder.shown_file
    assert [title.partition(",")[0] for title in shown[0]] == list(ALGORITHMS)
    assert left_out(tmp_path).startswith("3 of 15 runs are shown; --runs NAME ...")
    recording_in(tmp_path, recorder, ["run-04", "run-14"])
    assert len(shown[1]) == 2
