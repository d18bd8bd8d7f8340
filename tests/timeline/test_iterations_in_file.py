"""Newton iterations are in `results.vtkhdf` itself: a folder that was copied without its text files still has them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from contactlab.api import Iteration
from contactlab.api.frame import OPEN, STICK
from contactlab.results.load import load_results
from contactlab.results.result_file import FILE
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
STATICS = {"integrator": {"use": "newton", "steps": 6}, "time.end": 1.0, "supports.1.uy.to": -0.05}


def alone(folder: Path) -> Path:
    """A folder that has nothing but the file."""
    copy = folder.with_name(f"{folder.name}-copied")
    copy.mkdir()
    shutil.copy(folder / FILE, copy)
    return copy


def test_the_file_alone_has_the_record(small_scene: MakeScene, tmp_path: Path) -> None:
    run = simulate(small_scene(STATICS), tmp_path / "run")
    rows = load_results(alone(tmp_path / "run")).iterations
    assert len(rows) == run.summary["iterations"] > 6
    assert rows == run.iterations
    assert [type(value) for value in rows[0]] == [type(value) for value in run.iterations[0]]
    for row in rows:
        assert np.count_nonzero(row.active_set) == row.active
        assert np.count_nonzero(row.active_set == STICK) == row.sticking
    last = next(row for row in reversed(rows))
    steps = run.contact["contacts.0"].steps
    np.testing.assert_array_equal(last.active_set > OPEN, steps["state"][-1] > OPEN)


@pytest.mark.full
def test_a_file_without_active_sets_is_read_and_taken_up(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As files were before: what is missing is empty, and rows are whole."""
    monkeypatch.setattr("contactlab.run.restart.RESUMABLE", ("timed-out",))
    monkeypatch.setattr("contactlab.results.vtkhdf.RESUMABLE", ("timed-out",))
    with monkeypatch.context() as before:
        before.setattr("contactlab.implicit.iteration.Iteration", lambda *row: Iteration(*row[:7]))
        begun = simulate(small_scene(STATICS), tmp_path / "run", work=9)
        assert begun.status == "timed-out"
        assert {row.statuses for row in begun.iterations} == {""}
    rows = simulate(small_scene(STATICS), tmp_path / "run", resume=True).iterations
    known = [bool(row.statuses) for row in rows]
    assert not known[0]
    assert known[-1]
    assert known == sorted(known)


def test_steps_taken_back_are_in_it(small_scene: MakeScene, tmp_path: Path) -> None:
    """One iteration is never enough for a first contact: what was tried is what one wants to read then."""
    hopeless = STATICS | {"integrator": {"use": "newton", "steps": 6, "iterations": 1}}
    run = simulate(small_scene(hopeless), tmp_path / "run")
    assert run.status == "not-converged"
    rows = load_results(alone(tmp_path / "run")).iterations
    assert rows == run.iterations
    assert max(row.attempt for row in rows) > 3


def test_explicit_runs_have_no_such_record(small_scene: MakeScene, tmp_path: Path) -> None:
    simulate(small_scene(), tmp_path / "run")
    with h5py.File(tmp_path / "run" / FILE) as file:
        assert "iterations" not in file["contactlab"]
    assert load_results(tmp_path / "run").iterations == []
