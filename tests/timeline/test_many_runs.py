"""Runs of one process, one after the other: none leaves threads or memory behind."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from contactlab.run.simulation import simulate

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="threads of libraries are counted in /proc")
ALL = {"record.recorders": ["vtkhdf", {"use": "rerun", "write": "run"}], "time.end": 1e-6, "record.frames": 5}
# 12 runs used to leave 48 threads and 30 MiB; what allocators keep of one run is below a tenth of that
NOISE = 10.0 * 2**20


def threads() -> int:
    """Threads of this process, those of its libraries among them."""
    return len(list(Path("/proc/self/task").iterdir()))


def threads_that_stay(most: int) -> int:
    """Threads of this process once those of a closed stream have ended, for which nobody waits: up to two seconds."""
    for _ in range(100):
        if threads() <= most:
            break
        time.sleep(0.02)
    return threads()


def resident() -> int:
    """Bytes of this process in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def test_runs_leave_no_threads_and_no_memory_behind(small_scene: Callable[..., Any], tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed (plugin contactlab-rerun)")
    scene = small_scene(ALL)
    for number in range(3):
        simulate(scene, tmp_path / f"first-{number}")
    before, memory = threads(), resident()
    for number in range(12):
        simulate(scene, tmp_path / f"run-{number}")
    assert (tmp_path / "run-11" / "timeline.rrd").is_file()
    assert threads_that_stay(before) <= before
    assert resident() - memory < NOISE
