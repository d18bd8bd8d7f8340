"""Room in a growing file is taken before HDF5 hears of it, whole chunks and all."""

from __future__ import annotations

from pathlib import Path

import pytest

from contactlab.results.growing import METADATA, Column, GrowingFile


@pytest.mark.parametrize("together", [1, 4096, 32768])
def test_a_row_more_may_take_a_whole_chunk(together: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reserved: list[int] = []
    reserve = GrowingFile.reserve

    def noted(self: GrowingFile, size: int, metadata: int = METADATA) -> None:
        reserved.append(size)
        reserve(self, size, metadata)

    monkeypatch.setattr(GrowingFile, "reserve", noted)
    growing = GrowingFile(tmp_path / "file", new=True)
    columns = [Column(growing.file, name, "f8", 2, (3,), together) for name in ("a", "b")]
    growing.flush()
    for rows in (1, 1, 5000, 1):
        before = growing.file.id.get_filesize()
        growing.grow(columns, rows)
        # chunks, what tells where they are, and headers: nothing beyond what was set aside
        assert growing.file.id.get_filesize() - before <= reserved[-1] + METADATA
    growing.close()
