"""Names that no folder or file can have, and scenes that are no files, are refused in words."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest
from inline import runs_inline

from contactlab.cli import main
from contactlab.run.folders import fresh_folder


@pytest.mark.parametrize("command", ["run", "compare"])
@pytest.mark.parametrize("out", ["", "x" * 300])
def test_a_folder_that_cannot_be(
    command: str, out: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([command, "disc-on-block", "--out", out]) == 2
    told = capsys.readouterr().err
    assert "allowed" in told
    assert "Traceback" not in told
    assert not list(tmp_path.iterdir())


def test_a_long_name_of_a_scene_is_cut_for_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert fresh_folder("y" * 300).is_dir()


@pytest.mark.parametrize("request_", ["x" * 300, "/dev/urandom", "pipe.toml"])
def test_a_scene_that_is_no_file(
    request_: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.toml")
    done: list[int] = []
    call = threading.Thread(target=lambda: done.append(main(["run", request_, "--out", "new"])), daemon=True)
    call.start()
    call.join(30.0)
    assert done == [2], "it reads without end"
    assert "allowed" in capsys.readouterr().err


def test_a_comparison_on_a_full_disk_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import contactlab.comparison

    def full(table: object, folder: Path) -> None:
        raise OSError(28, "No space left on device", str(folder))

    monkeypatch.setattr(contactlab.comparison, "write_report", full)
    words = ["--set", "time.end=1e-7", "--set", "record.recorders=[]", "--vary", "contacts.0.swap=[false]"]
    with runs_inline():
        assert main(["compare", "disc-on-block", *words, "--out", str(tmp_path / "out")]) == 1
    told = capsys.readouterr().err
    assert "no space left on device" in told
    assert "--resume" in told
    assert (tmp_path / "out/table.csv").exists()
