"""Stages from a fresh clone are timed as a whole, marks when they are there, and moments of a run once."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])


def test_every_moment_of_a_run_counts_once(monkeypatch: pytest.MonkeyPatch) -> None:
    import first_second

    now = [first_second.BEGAN]
    monkeypatch.setattr(first_second, "process_time", lambda: now[0])
    split = first_second.Split()

    def passing(seconds: float) -> None:
        now[0] += seconds

    imported = split.of("imports", passing)

    def recorded() -> None:
        passing(2.0)
        imported(4.0)  # the library of a recorder, imported while it records
        split.of("imports", lambda: imported(8.0))()  # and what that imports
        passing(16.0)

    split.of("recording", recorded)()
    passing(32.0)
    split.begin("rest")
    assert split.seconds["recording"] == pytest.approx(18.0)
    assert split.seconds["imports"] == pytest.approx(12.0)
    assert split.seconds["rest"] == pytest.approx(32.0)
    assert sum(split.seconds.values()) == pytest.approx(now[0])


def test_a_span_ends_where_its_function_fails() -> None:
    import first_second

    split = first_second.Split()

    def fails() -> None:
        raise ImportError("no such module")

    with pytest.raises(ImportError):
        split.of("imports", fails)()
    assert split._open == ["rest"]


def test_a_stage_is_told_with_its_marks_and_the_time_of_all_its_processes(tmp_path: Path) -> None:
    import stages

    place = stages.Place(tmp_path)
    place.clone.mkdir()
    busy = "sum(range(3_000_000))"
    program = (
        f"import subprocess, sys, pathlib; subprocess.run([sys.executable, '-c', {busy!r}]); "
        f"pathlib.Path('page').touch(); {busy}"
    )
    marks = {"page [s]": (place.clone / "page").exists}
    stages.told(place, "both", [sys.executable, "-c", program], empty_cache=True, marks=marks)
    (wall,), (cpu,), (there,) = place.rows["both [s]"], place.rows["both [CPU s]"], place.rows["page [s]"]
    assert 0.0 < there <= wall
    assert cpu > 0.0
    with pytest.raises(SystemExit, match="page"):
        stages.told(place, "none", [sys.executable, "-c", ""], marks={"page": lambda: False})
