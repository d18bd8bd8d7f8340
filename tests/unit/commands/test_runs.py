"""`contactlab runs`: what tells result folders apart, and removing some of them."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import pytest

from contactlab.cli import main
from contactlab.results.inventory import differences, flat
from contactlab.scene.scene import load_scene

SCENE = load_scene("disc-on-block")


def run_folder(folder: Path, number: int, status: str | None, **changes: object) -> None:
    folder.mkdir(parents=True)
    (folder / "scene.toml").write_text(SCENE.with_(changes).toml())
    if status is not None:
        (folder / "summary.json").write_text(json.dumps({"status": status}))
    for file in folder.iterdir():
        os.utime(file, (1e9 + number, 1e9 + number))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    runs = tmp_path / "runs"
    run_folder(runs / "disc-on-block-002", 1, "finished")
    run_folder(runs / "disc-on-block-001", 2, "diverged", **{"level": 2, "contacts.0.algorithm": "node-on-segment"})
    run_folder(runs / "mine", 3, None)
    (runs / "notes").mkdir()
    study = {"scene": "disc-on-block", "vary": {"contacts.0.swap": [False, True]}}
    (runs / "both").mkdir()
    rows = [{"status": "finished"}, {"status": "diverged"}]
    (runs / "both/table.json").write_text(json.dumps({"study": study, "rows": rows}))
    return tmp_path


def listed(capsys: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    assert main(["runs", "--json"]) == 0
    return list(json.loads(capsys.readouterr().out)["folders"])


def test_folders_are_told_apart(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = {Path(str(one["folder"])).name: one for one in listed(capsys)}
    assert list(found) == ["disc-on-block-002", "disc-on-block-001", "mine", "both"]  # by date
    assert found["disc-on-block-002"]["changed"] == {}
    assert found["disc-on-block-001"]["changed"] == {"level": 2, "contacts.0.algorithm": "node-on-segment"}
    assert [found[name]["status"] for name in found] == ["finished", "diverged", "interrupted", "1 of 2 finished"]
    assert found["both"]["changed"] == {"contacts.0.swap": [False, True]}
    assert all(int(str(one["bytes"])) > 0 for one in found.values())


@pytest.mark.parametrize(
    ("names", "left"),
    [
        (["mine"], ["both", "disc-on-block-001", "disc-on-block-002"]),
        (["disc-*"], ["both", "mine"]),
        (["failed"], ["disc-on-block-002"]),
        (["runs/mine", "both"], ["disc-on-block-001", "disc-on-block-002"]),
    ],
)
def test_some_are_removed(here: Path, names: list[str], left: list[str]) -> None:
    assert main(["runs", "--remove", *names, "--yes"]) == 0
    assert sorted(path.name for path in (here / "runs").iterdir()) == sorted([*left, "notes"])


def test_what_is_no_result_is_never_removed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["runs", "--remove", "notes", "--yes"]) == 2
    assert (here / "runs/notes").is_dir()
    assert "no such result folder" in capsys.readouterr().err


def test_nothing_is_removed_without_an_answer(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    assert main(["runs", "--remove", "mine"]) == 2
    assert "--yes" in capsys.readouterr().err
    assert (here / "runs/mine").is_dir()


def laboratory(runs: Path) -> None:
    """A matrix of three cells, one of them with several measures, a choice, an error budget, and an interrupted one."""
    cells = [{"case": "patch", "verdict": verdict, "measures": [1, 2, 3]} for verdict in ("silent", "met", "met")]
    point = {"status": "diverged"}
    files = {
        "matrix/matrix.json": {"cells": cells}, "chosen/choose.json": {"verdict": "cannot", "choice": {"level": 2}},
        "budget/error-budget.json": {"status": "finished"},
        "accuracy/accuracy.json": {"points": [point], "interrupted": False},
    }  # fmt: skip
    for name, data in files.items():
        (runs / name).parent.mkdir()
        (runs / name).write_text(json.dumps(data))
        (runs / name).with_name("archive.sqlite").touch()
    (runs / "stopped").mkdir()
    (runs / "stopped/archive.sqlite").touch()


def test_folders_of_all_commands_are_listed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A matrix has a verdict for each cell, not for each measure; what was stopped is listed as well."""
    laboratory(here / "runs")
    found = {Path(str(one["folder"])).name: one["status"] for one in listed(capsys)}
    assert {name: found[name] for name in ("matrix", "chosen", "budget", "accuracy", "stopped")} == {
        "matrix": "2 met, 1 silent", "chosen": "cannot", "budget": "finished", "accuracy": "1 diverged",
        "stopped": "interrupted",
    }  # fmt: skip


def test_what_has_ended_is_no_failure_whatever_it_found(here: Path) -> None:
    laboratory(here / "runs")
    assert main(["runs", "--remove", "failed", "--yes"]) == 0
    left = sorted(path.name for path in (here / "runs").iterdir())
    assert left == ["accuracy", "budget", "chosen", "disc-on-block-002", "matrix", "notes"]


def test_one_folder_is_no_folders(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["runs", "--remove", "mine", "--yes"]) == 0
    assert "removed 1 folder," in capsys.readouterr().out


def test_another_part_stands_for_its_fields() -> None:
    base = flat({"a": {"use": "x", "k": 1.0}, "b": [{"c": 1}, {"c": 2}]})
    assert differences(flat({"a": {"use": "y", "m": 2.0}, "b": [{"c": 1}, {"c": 2}]}), base) == {"a": "y"}
    assert differences(flat({"a": {"use": "x", "k": 3.0}, "b": [{"c": 1}]}), base) == {"a.k": 3.0, "b.1.c": None}
