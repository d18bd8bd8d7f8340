"""Benchmarks compare within one kind of machine only, and say on what they ran."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"
FOLDERS = (BENCHMARKS, BENCHMARKS / "kernels", BENCHMARKS / "studies")


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*map(str, FOLDERS), *sys.path])


def a_machine(processor: str = "one", llvm: str = "20.1") -> dict[str, Any]:
    speed = {"median": 9.0, "least": 8.0, "largest": 9.5}
    software = {"LLVM": llvm, "Python": "3.11.7", "contactlab": "0.1.0"}
    return {"processor": processor, "cores": 2, "caches": {"L2": "2048K"}, "bandwidth": speed, "software": software}


def entry(machine: dict[str, Any] | None, commit: str, **ratios: float) -> dict[str, Any]:
    return {"machine": machine, "date": "2026-01-01", "version": f"0.1.{commit}", "commit": commit, "ratios": ratios}


def test_the_newest_of_the_same_kind_is_compared_with() -> None:
    import baselines

    kept = [
        entry(None, "0"), entry(a_machine(llvm="19.1"), "1"), entry(a_machine(), "2"), entry(a_machine("other"), "3")
    ]  # fmt: skip
    found = baselines.like(kept, a_machine(llvm="21.0"))
    assert found is not None
    assert found["commit"] == "2"
    assert baselines.like(kept, a_machine("third")) is None
    told = baselines.no_like(kept)
    assert told.startswith("no baseline of this kind of machine")
    assert "one not noted" in told
    assert "other (2 cores" in told


def test_ratios_of_one_commit_and_kind_are_kept_once(tmp_path: Path) -> None:
    import baselines

    file = tmp_path / "kept.json"
    baselines.keep([], entry(a_machine(), "1", speed=1.23456789), file)
    baselines.keep(baselines.load(file), entry(a_machine("other"), "1", speed=3.0), file)
    baselines.keep(baselines.load(file), entry(a_machine(), "1", speed=2.0), file)
    assert [(e["machine"]["processor"], e["ratios"]["speed"]) for e in baselines.load(file)] == [
        ("other", 3.0), ("one", 2.0)
    ]  # fmt: skip


def test_a_run_without_a_baseline_of_its_kind_judges_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import baselines
    import bench

    measured = {"machine": a_machine("new")}
    monkeypatch.setattr(bench, "measure", lambda *_: measured)
    monkeypatch.setattr(bench, "ratios_of", lambda found: {"times akantu": 1.0})
    pages: list[str] = []
    monkeypatch.setattr(bench, "write_page", lambda found, lost, against, folder: pages.append(against))
    kept = [entry(a_machine("old"), "1", **{"times akantu": 9.0})]
    monkeypatch.setattr(baselines, "load", lambda: kept)
    assert bench.main(["--out", str(tmp_path)]) == 0
    assert "Nothing to compare with" in capsys.readouterr().out
    assert "old" in pages[-1]
    kept.append(entry(a_machine("new"), "2", **{"times akantu": 9.0}))
    assert bench.main(["--out", str(tmp_path)]) == 1
    assert "<-- 89% lost" in capsys.readouterr().out
    assert pages[-1].startswith("version 0.1.2")
