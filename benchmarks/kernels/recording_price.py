"""What recording adds to a run: whole runs of disc-on-block with and without recorders, by turns in one process.

All of it counts, on all threads: opening, frames, every step's scalars, the contact record, the end of both files. The
first round compiles and imports and is left out. What a run without recorders costs is there in either.

    chrt -f 50 taskset -c 0 python benchmarks/kernels/recording_price.py --levels 1 2 --rounds 9
"""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

KINDS: dict[str, dict[str, Any]] = {
    "none": {"record.recorders": []},
    "vtkhdf": {"record.recorders": ["vtkhdf"]},
    "rerun": {"record.recorders": ["rerun"]},
    "both": {},
    "both, no contact record": {"record.budget": 0},
}


def spent(scene: Any) -> tuple[float, int]:
    """CPU seconds of all threads in one run, and its steps."""
    with tempfile.TemporaryDirectory() as folder:
        began = process_time()
        run = simulate(scene, Path(folder) / "run")
        return process_time() - began, int(run.summary["steps"])


def level_report(level: int, rounds: int) -> None:
    """Print medians, and shares as medians of ratios within a round."""
    scenes = {kind: load_scene("disc-on-block").with_({"level": level, **changes}) for kind, changes in KINDS.items()}
    times: dict[str, list[float]] = {kind: [] for kind in scenes}
    for number in range(rounds + 1):
        for kind, scene in scenes.items():
            seconds, steps = spent(scene)
            if number:
                times[kind].append(seconds)
    print(f"\nlevel {level}: {steps} steps, {median(times['none']):.3f} s without recorders")
    for kind in list(scenes)[1:]:
        shares = [with_it / without - 1.0 for with_it, without in zip(times[kind], times["none"], strict=True)]
        added = median(times[kind]) - median(times["none"])
        print(f"  {kind:24s} +{added:.3f} s, {median(shares):6.1%} of a run, {1e6 * added / steps:6.1f} us per step")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--levels", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    for level in options.levels:
        level_report(level, options.rounds)


if __name__ == "__main__":
    main()
