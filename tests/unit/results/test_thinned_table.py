"""Tables of steps that are thinned in place when they are full."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from tiers import some

from contactlab.api.thinning import Thinning, thinned
from contactlab.results import journaled, thinned_table
from contactlab.results.growing import INDICES, Column, GrowingFile
from contactlab.results.journaled import JournaledFile
from contactlab.results.thinned_table import ThinnedTable, pieces_of

MOST = 64


class Killed(Exception):
    """The process is gone."""


def opened(path: Path, new: bool) -> tuple[GrowingFile, ThinnedTable]:
    growing = GrowingFile(path, new)
    rows = Column(growing.file, "rows", "f8", 1, (3,), 8)

    def look(begin: int, end: int) -> Any:
        values = rows.rows(begin, end)
        return values[:, 0].astype(np.int64), values[:, 1] > 0.0

    return growing, ThinnedTable(growing, rows.dataset, [rows], look, MOST, 16)


def fill(growing: GrowingFile, table: ThinnedTable, begin: int, end: int, together: int, chance: float) -> None:
    """Rows of steps begin + 1 to end; each step has numbers of its own, whoever makes it."""
    while begin < end:
        steps = np.arange(begin + 1, min(end, begin + together) + 1)
        changed = np.array([random.Random(int(step)).random() < chance for step in steps])
        table.add([np.column_stack([steps, changed, np.sin(steps)])], steps)
        begin = int(steps[-1])
        table.show()
        growing.flush()


def read(path: Path) -> np.ndarray:
    over = JournaledFile.read_only(path)
    with h5py.File(path if over is None else over, "r") as file:
        return np.concatenate([file["rows"][begin:end] for begin, end in pieces_of(file["rows"])])


@pytest.fixture(autouse=True)
def small_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thinned_table, "AT_ONCE", 16 * 24)  # 16 rows


@pytest.mark.parametrize(("chance", "together"), [(0.0, 7), (0.01, 256), (0.6, 5)])
def test_what_stays(chance: float, together: int, tmp_path: Path) -> None:
    growing, table = opened(tmp_path / "file", new=True)
    growing.publish()
    fill(growing, table, 0, 1000, together, chance)
    kept = read(tmp_path / "file")
    steps, changed, thinning = kept[:, 0].astype(int), kept[:, 1] > 0.0, table.thinning
    assert len(steps) <= MOST
    assert np.array_equal(kept[:, 2], np.sin(steps))
    every, until = np.arange(1, 1001), thinning.until
    assert set(every[every > until]) <= set(steps)
    assert set(every[every % thinning.stride == 0]) <= set(steps)
    assert np.all(np.diff(steps) > 0)
    if chance < 0.1:
        assert thinning.changes == 1
        assert {s for s in every if random.Random(int(s)).random() < chance} <= set(steps)
    else:  # they alone take more than there is room for
        assert thinning.changes > 1
        assert set(steps[changed & (steps <= until) & (steps % thinning.stride > 0)] % thinning.changes) == {0}
    growing.close()


@pytest.mark.parametrize(("chance", "apart"), some([(0.0, 9), (0.05, 9), (0.05, 31), (0.6, 9)], [(0.05, 31)]))
def test_a_kill_at_any_write_and_other_blocks_end_with_the_same_rows(
    chance: float, apart: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    growing, table = opened(tmp_path / "whole", new=True)
    growing.publish()
    fill(growing, table, 0, 400, 11, chance)
    growing.close()
    whole, write, left = read(tmp_path / "whole"), os.pwrite, [0]

    def killed(descriptor: int, data: Any, offset: int) -> int:
        left[0] -= 1
        if not left[0]:
            raise Killed
        return write(descriptor, data, offset)

    monkeypatch.setattr(journaled.os, "pwrite", killed)
    for number in range(12, 400, apart):
        path = tmp_path / f"killed-{number}"
        growing, table = opened(path, new=True)
        growing.publish()
        saved, left[0] = 0, number
        try:
            for end in range(20, 401, 20):
                fill(growing, table, end - 20, end, 13, chance)
                saved = end if end % 60 == 0 else saved
        except Killed:
            left[0] = -1
            shutil.copyfile(path, tmp_path / "as it lies")
            shutil.copyfile(journaled.journal_of(path), journaled.journal_of(tmp_path / "as it lies"))
            seen = read(tmp_path / "as it lies")
            assert np.array_equal(seen[:, 2], np.sin(seen[:, 0]))
            assert np.all(np.diff(seen[:, 0]) > 0)
            growing.below.writes.clear()
            growing, table = opened(tmp_path / "as it lies", new=False)
            table.cut(saved)
            fill(growing, table, saved, 400, 17, chance)
            path = tmp_path / "as it lies"
        left[0] = -1
        growing.close()
        assert np.array_equal(read(path), whole), number


def test_recent_steps_and_half_of_a_small_record_stay() -> None:
    steps = np.arange(1, 50_001)
    same = np.zeros(50_000, bool)
    found = thinned([(steps[:30_000], same[:30_000]), (steps[30_000:], same[30_000:])], 50_000, 50_000, Thinning())
    assert found == Thinning(40_000, 2, 1)
    assert np.count_nonzero(found.keeps(steps, same)) == 30_000
    assert thinned([(steps[:100], same[:100])], 100, 100, Thinning()).until == 50


@pytest.mark.parametrize("before", [Thinning(), Thinning(100, 4, 1), Thinning(100, 16, 2)])
def test_counts_of_kept_rows_need_no_rows_at_hand(before: Thinning) -> None:
    """The next thinning is the first one, in the order of the rule, that leaves at most three quarters."""
    steps, most = np.arange(3000), 3000
    changed = np.random.default_rng(5).random(3000) < 0.7
    keeps = before.keeps(steps, changed)
    steps, changed = steps[keeps], changed[keeps]
    most = len(steps)
    found = thinned([(steps[:900], changed[:900]), (steps[900:], changed[900:])], 2999, most, before)
    tried = before._replace(until=2999 - most // 2)
    while np.count_nonzero(tried.keeps(steps, changed)) > 0.75 * most:
        older = steps <= tried.until
        sparse = np.count_nonzero(steps[older] % tried.stride == 0) > most // 16
        tried = tried._replace(**({"stride": 2 * tried.stride} if sparse else {"changes": 2 * tried.changes}))
    assert found == tried


@pytest.mark.full
def test_hdf5_keeps_no_more_of_a_file_than_it_is_allowed(tmp_path: Path) -> None:
    """Indices of chunks grow with the rows: unless what HDF5 holds of them is bounded, runs grow by 2 bytes a step."""
    growing = GrowingFile(tmp_path / "file", new=True)
    rows = Column(growing.file, "rows", "f8")
    for number in range(8):
        growing.grow([rows], 10_000)
        rows.write(number * 10_000, np.zeros(10_000), 10_000)
    _, _, held, _ = growing.file.id.get_mdc_size()
    assert growing.below.path.stat().st_size > 4 * INDICES
    assert held <= 1.5 * INDICES  # what is in use may exceed it for a moment
    growing.close()
