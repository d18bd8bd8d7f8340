"""Runs of one process, one after the other: none leaves threads or memory behind."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from contactlab.run.simulation import simulate

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="threads of libraries are counted in /proc")
ALL = {"record.recorders": ["vtkhdf", {"use": "rerun", "write": "run"}], "time.end": 1e-6, "record.frames": 5}
# 12 runs used to leave 48 threads and 30 MiB; what allocators keep of one run is below a tenth of that
NOISE = 10.0 * 2**20


# in a process that holds nothing else: what other tests have started there may come and go meanwhile
SCRIPT = """
import sys, time
from pathlib import Path
import contactlab

def threads():
    return len(list(Path("/proc/self/task").iterdir()))

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

folder = Path(sys.argv[1])
scene = contactlab.load_scene(folder / "first" / "scene.toml")
for number in range(3):
    contactlab.simulate(scene, folder / f"warm-{number}")
before, memory = threads(), resident()
for number in range(12):
    contactlab.simulate(scene, folder / f"run-{number}")
for _ in range(100):  # threads of a closed stream end by themselves, and nobody waits for them
    if threads() <= before:
        break
    time.sleep(0.02)
print(before, threads(), resident() - memory)
"""


@pytest.mark.full
def test_runs_leave_no_threads_and_no_memory_behind(small_scene: Callable[..., Any], tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed (plugin contactlab-rerun)")
    simulate(small_scene(ALL), tmp_path / "first")
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path)], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    before, after, grown = (int(word) for word in done.stdout.split())
    assert (tmp_path / "run-11" / "timeline.rrd").is_file()
    assert after <= before
    assert grown < NOISE
