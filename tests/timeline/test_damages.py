"""A damaged `results.vtkhdf` gives what was stored or one message, and salvage gives what is whole."""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from damages import damage, everything, outcome
from tiers import some

import contactlab
from contactlab.errors import RequestError
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
DAMAGES = 20
GOOD = ("as before", "told", "told, some salvaged")


@pytest.fixture(scope="module")
def stored(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("stored") / "run"
    simulate(small_scene({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}), folder)
    return folder


def test_random_damage_is_told_or_without_effect(stored: Path, tmp_path: Path) -> None:
    whole, chance = everything(stored), random.Random(4815)
    seen: dict[str, int] = {}
    for number in range(DAMAGES):
        folder = tmp_path / str(number)
        folder.mkdir()
        shutil.copy(stored / "results.vtkhdf", folder)
        way = damage(folder / "results.vtkhdf", chance)
        came = outcome(folder, whole)
        assert came in GOOD, f"{way}: {came}"
        seen[came] = seen.get(came, 0) + 1
        shutil.rmtree(folder)
    assert seen.get("told", 0) + seen.get("told, some salvaged", 0) >= DAMAGES // 10, seen
    assert seen.get("told, some salvaged", 0) >= 1, seen  # most of so small a file tells what is where


TABLES = [
    ("VTKHDF/PointData/displacement", "frame 7"),
    ("VTKHDF/CellData/stress", "frame 7"),
    ("VTKHDF/Points", "frame 7"),
    ("contactlab/contacts/contacts.0/curves", "frame 7"),
    ("contactlab/history", "frame 7"),
    ("contactlab/steps", "1 of"),
]


@pytest.mark.parametrize(
    ("place", "lost"),
    some(TABLES, [TABLES[0], TABLES[2], TABLES[5]]),
)
def test_each_table_has_checksums(place: str, lost: str, stored: Path, tmp_path: Path) -> None:
    """One number changed the way a program could: HDF5 itself finds nothing wrong."""
    shutil.copytree(stored, tmp_path / "run")
    whole = everything(stored)
    with h5py.File(tmp_path / "run/results.vtkhdf", "r+") as file:
        table = file[place]
        row = table.shape[0] // len(whole["frames"]) * 7
        values = table[row]
        np.atleast_1d(values)[...] = np.atleast_1d(values) + 1e-9
        table[row] = values
    left = contactlab.load_results(tmp_path / "run", salvage=True)
    assert left.lost
    assert left.lost[0].startswith(lost)
    if lost.startswith("frame"):
        assert [frame.number for frame in left.frames] == [n for n in range(len(whole["frames"])) if n != 7]
        assert len(left.history["time"]) == len(whole["frames"]) - 1
    else:
        assert len(left.steps["step"]) == len(whole["steps"]["step"]) - 1
    if place == "VTKHDF/Points":
        return  # read by VTK alone: found by salvage, and before a run is taken up
    with pytest.raises(RequestError) as error:
        everything(tmp_path / "run")
    assert "salvage=True" in str(error.value)
    assert "damaged" in str(error.value)
    with pytest.raises(RequestError, match="damaged"):
        contactlab.simulate(contactlab.load_scene(stored / "scene.toml"), tmp_path / "run", resume=True)
