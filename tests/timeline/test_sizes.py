"""A folder of a small run is small, and has every step's scalars."""

from __future__ import annotations

from pathlib import Path

import pytest
from tiers import some

import contactlab

pytest.importorskip("contactlab_rerun", reason="plugin contactlab-rerun is not installed")


@pytest.mark.full
@pytest.mark.parametrize("frames", some([50, 12], [50]))
def test_360_cells_leave_a_megabyte(frames: int, tmp_path: Path) -> None:
    scene = contactlab.load_scene("disc-on-block").with_({"record.frames": frames})
    results = contactlab.simulate(scene, out=tmp_path)
    assert sum(map(len, results.cells.values())) == 360
    assert results.steps["step"].tolist() == list(range(1, results.summary["steps"] + 1))
    sizes = {file.name: file.stat().st_size for file in tmp_path.iterdir()}
    assert {"results.vtkhdf", "timeline.rrd", "history.csv"} <= sizes.keys()
    assert sum(sizes.values()) <= 1_000_000, sizes
