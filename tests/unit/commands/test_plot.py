"""`contactlab plot`: every kind of picture of a run and of a comparison, and what is refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from inline import runs_inline
from tiers import some

import contactlab
from contactlab import load_scene
from contactlab.cli import main
from contactlab.errors import RequestError
from contactlab.reports.notebook.pictures import fields_figure

SMALL = {
    "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "supports.1.uy.to": -0.02, "level": 1,
    "integrator": "newton", "integrator.steps": 4, "time.history": True, "record.frames": 4,
    "record.recorders": ["vtkhdf"],
}  # fmt: skip
HEADS = {".png": b"\x89PNG", ".pdf": b"%PDF", ".gif": b"GIF8", ".svg": b"<?xml"}


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    place = tmp_path_factory.mktemp("plot")
    scene = contactlab.load_scene("disc-on-block").with_(SMALL)
    contactlab.simulate(scene, out=place / "run")
    with runs_inline(report=False):
        contactlab.compare(scene, {"contacts.0.swap": [False, True]}, out=place / "two", jobs=1, progress=False)
    return {"run": place / "run", "two": place / "two"}


PICTURES = [("force", ".pdf"), ("pressure", ".svg"), ("stress", ".png"), ("animation", ".gif")]
EACH = [(which, *picture) for which in ("run", "two") for picture in PICTURES]


@pytest.mark.parametrize(("which", "what", "suffix"), some(EACH, EACH[:3]))
def test_every_kind_of_picture(
    folders: dict[str, Path], which: str, what: str, suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = folders[which] / f"{what}-there{suffix}"
    assert main(["plot", str(folders[which]), what, "--out", str(file)]) == 0
    assert file.read_bytes().startswith(HEADS[suffix])
    assert capsys.readouterr().out == f"{what}: {file}\n"


def test_a_picture_without_a_name_lies_beside_the_results(folders: dict[str, Path]) -> None:
    assert main(["plot", str(folders["run"]), "force", "--on", "disc.top"]) == 0
    assert (folders["run"] / "force.png").read_bytes().startswith(HEADS[".png"])


@pytest.mark.full
def test_frames_fields_and_runs_are_chosen(folders: dict[str, Path]) -> None:
    run, two = str(folders["run"]), str(folders["two"])
    assert main(["plot", run, "stress", "--field", "principal_3", "--frame", "1", "--flat"]) == 0
    (name, *_) = (path.name for path in (folders["two"] / "runs").iterdir())
    assert main(["plot", two, "stress", "--runs", name]) == 0


def test_a_comparison_that_is_loaded_as_a_run_is_named_as_such(folders: dict[str, Path]) -> None:
    with pytest.raises(RequestError, match="load_table reads a comparison; its runs are folders in runs"):
        contactlab.load_results(folders["two"])


@pytest.mark.full
@pytest.mark.parametrize("number", [2, 6])
def test_runs_side_by_side_have_their_titles_and_supports(folders: dict[str, Path], number: int) -> None:
    """Long titles of neighbours were written over each other."""
    results = contactlab.load_results(folders["run"])
    names = {f"node-on-segment, slave {side}, mu {mu}, level 2": results for side in "ab" for mu in (0.1, 0.2, 0.3)}
    figure = fields_figure(dict(list(names.items())[:number]), "von_mises", -1)
    for _ in range(2):  # as when it is saved
        figure.draw_without_rendering()
    places = [axes for axes in figure.axes if axes.get_title(loc="left")]
    assert len(places) == number
    boxes = [axes._left_title.get_window_extent() for axes in places]  # type: ignore[attr-defined]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    assert all(len(axes.lines) >= len(load_scene("disc-on-block").supports) for axes in places)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["force", "--out", "x.gif"], ".pdf"),
        (["animation", "--out", "x.png"], ".gif"),
        (["force", "--on", "disc.tp"], 'did you mean "disc.top"'),
        (["stress", "--field", "vonmises"], 'did you mean "von_mises"'),
        (["stress", "--frame", "99"], "there is no such frame"),
        (["force", "--out", "nowhere/x.png"], "there is no such folder"),
        (["forse"], 'did you mean "force"'),
    ],
)
def test_wrong_requests(
    folders: dict[str, Path], words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["plot", str(folders["run"]), *words]) == 2
    assert said in capsys.readouterr().err


def test_a_film_without_ffmpeg_names_gif(
    folders: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert main(["plot", str(folders["run"]), "animation", "--out", str(tmp_path / "x.mp4")]) == 2
    said = capsys.readouterr().err
    assert "ffmpeg" in said
    assert ".gif" in said


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg here")
def test_a_film(folders: dict[str, Path], tmp_path: Path) -> None:
    assert main(["plot", str(folders["run"]), "animation", "--out", str(tmp_path / "x.mp4")]) == 0
    assert b"ftyp" in (tmp_path / "x.mp4").read_bytes()[:16]


def test_an_empty_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", str(tmp_path), "force"]) == 2
    assert "results.vtkhdf" in capsys.readouterr().err
