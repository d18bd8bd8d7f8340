"""Figures of the paper's page come from an archive of runs, and their numbers are those of today."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from contactlab.jobs.archive import FILE, Archive

STUDY = Path(__file__).parents[2] / "benchmarks" / "studies" / "paper"


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, ModuleType]]:
    """The modules of the study, with pictures and archive in a folder of the test."""
    path = list(sys.path)
    sys.path[:0] = [str(STUDY), str(STUDY.parent)]
    found = {name: importlib.import_module(name) for name in ("common", "kept_runs", "make", "test1")}
    monkeypatch.setattr(found["common"], "PICTURES", tmp_path)
    monkeypatch.setattr(found["kept_runs"], "source", found["kept_runs"].Source(tmp_path))
    found["common"]._disc.cache_clear()
    yield found
    found["common"]._disc.cache_clear()
    sys.path[:] = path


@pytest.mark.full
def test_a_figure_is_drawn_from_the_archive_with_the_numbers_of_the_page(
    study: dict[str, ModuleType], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """P0 beside P1: two runs are made, kept, and found again; the page has what they say today."""
    kept, figure = study["kept_runs"], study["test1"].figure_9
    with Archive(tmp_path / FILE):
        pass
    kept.use(tmp_path, only_kept=True)
    assert not kept.held(tmp_path)
    with pytest.raises(kept.MissingRunError, match="make paper"):
        figure()
    kept.use(tmp_path, only_kept=False)
    made = figure()
    assert kept.held(tmp_path)
    assert made == json.loads(study["make"].NUMBERS.read_text())["f09"]
    monkeypatch.setattr(kept.contactlab, "simulate", None)
    for only_kept in (False, True):
        study["common"]._disc.cache_clear()
        kept.use(tmp_path, only_kept=only_kept)
        (tmp_path / "figure-09.svg").unlink()
        assert figure() == made
        assert (tmp_path / "figure-09.svg").exists()


@pytest.mark.full
def test_every_figure_has_its_numbers(study: dict[str, ModuleType]) -> None:
    numbers = json.loads(study["make"].NUMBERS.read_text())
    assert set(numbers) == set(study["make"].known())
    assert "(not measured)" not in study["make"].filled(study["make"].PAGE.read_text(), numbers)


def test_what_is_kept_of_stored_frames_is_another_run(study: dict[str, ModuleType], tmp_path: Path) -> None:
    """A run whose frames are looked at, and one whose are not, do not stand in for each other."""
    import contactlab

    scene = contactlab.load_scene("two-bars").with_({"level": 1, "record.frames": 3})
    kept = study["kept_runs"]

    def ways(results: object) -> dict[str, object]:
        return {"ways": [frame.displacement[-1, 0] for frame in results.frames]}  # type: ignore[attr-defined]

    plain, looked = kept.run(scene), kept.run(scene, ways)
    assert plain.watched == {}
    assert len(kept.run(scene, ways).watched["ways"]["ways"]) == len(looked.watched["ways"]["ways"]) > 1
    with Archive(tmp_path / FILE, write=False) as archive:
        assert sorted(run["name"] for run in archive.runs()) == ["paper", "paper ways"]
