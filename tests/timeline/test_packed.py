"""The file of a run that is over is compressed, with fields as exactly as one looks at them; older files are read."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from contactlab.results.load import load_results
from contactlab.results.packed_file import SMALL, pack
from contactlab.results.precision import PLACES, placed
from contactlab.results.result_file import FILE
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
Same = Callable[[Results, Results], None]
SHORT = {"time.end": 3e-6, "record.frames": 5}


def test_places_are_those_of_the_largest_value() -> None:
    values = np.random.default_rng(1).normal(size=(50, 3)) * [1.0, 1e-3, 0.0]
    found, largest = placed(values, PLACES), np.abs(values).max()
    assert np.abs(found - values).max() <= largest * 2.0**-PLACES
    np.testing.assert_array_equal(placed(found, PLACES), found)
    assert not placed(np.zeros((4, 3)), PLACES).any()
    wild = np.array([1.0, np.inf, np.nan])
    np.testing.assert_array_equal(placed(wild, PLACES), wild.astype(np.float32))


def test_a_run_that_is_over_keeps_the_fields_of_its_end_alone(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("contactlab.results.vtkhdf.pack", lambda path: None)
    run = simulate(small_scene(SHORT), tmp_path / "run")
    before = load_results(tmp_path / "run")
    whole = _saved_numbers(tmp_path / "run")
    pack(tmp_path / "run" / FILE)
    after = load_results(tmp_path / "run")
    for seen in (before, after):
        np.testing.assert_array_equal(seen.displacement, run.displacement)
        np.testing.assert_array_equal(seen.velocity, run.velocity)
        for body in run.stress:
            np.testing.assert_array_equal(seen.stress[body], run.stress[body])
    assert (after.closed, after.status, after.summary) == (before.closed, "finished", before.summary)
    ends = _saved_numbers(tmp_path / "run")
    assert 0 < ends[0] == ends[1] < whole[0]


def _saved_numbers(folder: Path) -> list[int]:
    """Numbers in each of the two saved states."""
    with h5py.File(folder / FILE) as file:
        return [len(file[f"contactlab/checkpoint/{slot}/memory"]) for slot in (0, 1)]


def test_compressed_is_the_same_run(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, assert_same_run: Same
) -> None:
    monkeypatch.setattr("contactlab.results.vtkhdf.pack", lambda path: None)
    run = simulate(small_scene(SHORT), tmp_path / "run")
    shutil.copytree(tmp_path / "run", tmp_path / "packed")
    pack(tmp_path / "packed" / FILE)
    assert_same_run(run, load_results(tmp_path / "packed"))
    assert not list((tmp_path / "packed").glob("*.packed"))
    with h5py.File(tmp_path / "run" / FILE) as old, h5py.File(tmp_path / "packed" / FILE) as new:
        found: list[str] = []
        old.visit(found.append)
        names: list[str] = []
        new.visit(names.append)
        assert sorted(found) == sorted(names)
        assert new["VTKHDF/Steps"] == new["contactlab/shown/frames"]
        assert new["contactlab/steps"].compression == "gzip"
        tables = [new[name] for name in names if isinstance(new[name], h5py.Dataset) and "checkpoint" not in name]
        assert min(table.nbytes for table in tables if table.chunks) >= SMALL


def test_vtk_reads_what_is_compressed(small_scene: MakeScene, tmp_path: Path) -> None:
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK is not installed (extra: test)")
    run = simulate(small_scene(SHORT), tmp_path / "run")
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "run" / FILE))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(run.frames)
    reader.SetStep(len(run.frames) - 1)
    reader.Update()
    found = np.array(reader.GetOutputDataObject(0).GetPointData().GetArray("displacement"))
    np.testing.assert_array_equal(found[:, :2], load_results(tmp_path / "run").frames[-1].displacement)


def test_where_there_is_no_room_for_a_copy_the_file_stays(recorded: Results, tmp_path: Path, monkeypatch: Any) -> None:
    assert recorded.folder is not None
    file = tmp_path / FILE
    shutil.copy(recorded.folder / FILE, file)
    before = file.read_bytes()

    def full(*_: Any) -> None:
        raise OSError(28, "no space left on device")

    monkeypatch.setattr("contactlab.results.packed_file._copy_dataset", full)
    pack(file)
    assert file.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == [FILE]


@pytest.mark.full
def test_a_file_in_double_precision_is_read_and_taken_up(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As files were before: the run goes on in the precision that it began with."""
    with monkeypatch.context() as before:
        before.setattr("contactlab.results.grid_file.LOOKED_AT", "f8")
        before.setattr("contactlab.results.vtkhdf.pack", lambda path: None)
        begun = simulate(small_scene(SHORT), tmp_path / "run", work=100)
        assert begun.status == "timed-out"
    monkeypatch.setattr("contactlab.run.restart.RESUMABLE", ("timed-out",))
    run = simulate(small_scene(SHORT), tmp_path / "run", resume=True)
    assert (run.status, len(run.frames)) == ("finished", 6)
    with h5py.File(tmp_path / "run" / FILE) as file:
        assert file["VTKHDF/Points"].dtype == np.float64
    place = np.abs(run.displacement).max() * 2.0**-PLACES
    np.testing.assert_allclose(run.frames[-1].displacement, run.displacement, rtol=0.0, atol=place)
