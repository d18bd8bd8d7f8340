"""Which runs of a comparison keep what their recorders wrote."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from contactlab.comparison import compare, drop_files
from contactlab.errors import RequestError
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import load_scene

LARGE, SMALL = ("results.vtkhdf", "timeline.rrd"), ("summary.json", "contact.csv", "scene.toml")


@pytest.mark.parametrize(("keep", "stay"), [("all", ["a", "b"]), ("failed", ["b"]), ("none", [])])
def test_large_files_go_and_small_ones_stay(keep: str, stay: list[str], tmp_path: Path) -> None:
    pytest.importorskip("contactlab_rerun")
    rows: list[Any] = [SimpleNamespace(name="a", status="finished"), SimpleNamespace(name="b", status="diverged")]
    for row in rows:
        place = tmp_path / "runs" / row.name
        place.mkdir(parents=True)
        for name in (*LARGE, *SMALL):
            (place / name).touch()
    (tmp_path / "timeline.rrd").touch()
    drop_files(tmp_path, rows, keep, default_registry())
    assert (tmp_path / "timeline.rrd").exists()
    for row in rows:
        there = {path.name for path in (tmp_path / "runs" / row.name).iterdir()}
        assert there == {*SMALL, *(LARGE if row.name in stay else ())}


def test_another_word_is_refused_before_anything_is_run() -> None:
    with pytest.raises(RequestError, match="no such choice") as caught:
        compare("disc-on-block", keep="some")
    assert caught.value.allowed == "all, failed, none"


@pytest.mark.full
def test_a_comparison_that_keeps_nothing_can_be_taken_up_again(tmp_path: Path) -> None:
    """What was dropped is run again, and gives the same; the recording is made before its runs go."""
    pytest.importorskip("contactlab_rerun")
    scene = load_scene("disc-on-block").with_(
        {"record.recorders": ["vtkhdf", {"use": "rerun", "write": "view"}], "time.end": 2e-7, "supports.1.uy.to": -1e-3}
    )
    vary = {"contacts.0.algorithm": ["mortar-p0"]}
    first = compare(scene, vary, out=tmp_path / "out", jobs=1, keep="none")
    (place,) = (tmp_path / "out" / "runs").iterdir()
    assert not (place / "results.vtkhdf").exists()
    assert (tmp_path / "out" / "timeline.rrd").is_file()
    again = compare(scene, vary, out=tmp_path / "out", jobs=1, resume=True)
    assert (place / "results.vtkhdf").exists()
    assert not (tmp_path / "out" / "timeline.rrd").exists(), "it is of the runs before"
    assert again.rows[0].measures["reaction"] == first.rows[0].measures["reaction"]
