"""What recording adds to a run: whole runs of disc-on-block with and without recorders, by turns.

All of it counts, on all threads: opening, frames, every step's scalars, the contact record, the end of the files; in
one process, where everything is imported and compiled, and as a command with its start from a warm cache of kernels.
The first round is left out. What a run without recorders costs is there in either. The first look is timed as well.

    chrt -f 50 taskset -c 0 python benchmarks/kernels/recording_price.py --levels 1 2 --rounds 9
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from contactlab.parts.registry import default_registry
from contactlab.results.load import load_results
from contactlab.run.recorders import record_again
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

NONE, BOTH, VIEW = "none", "by default", "at the first look"
KINDS: dict[str, dict[str, Any]] = {
    NONE: {"record.recorders": []},
    BOTH: {},
    "without a contact record": {"record.budget": 0},
    VIEW: {"record.recorders": ["vtkhdf", {"use": "rerun", "write": "view"}]},
}


def in_this_process(scene: Scene, folder: Path) -> tuple[float, int]:
    """CPU seconds of all threads in one run, and its steps."""
    began = process_time()
    run = simulate(scene, folder / "run")
    return process_time() - began, int(run.summary["steps"])


def as_a_command(scene: Scene, folder: Path) -> tuple[float, int]:
    """CPU seconds of `contactlab run` in a process of its own, imports and all; its steps are not looked up."""
    file = folder / "scene.toml"
    file.write_text(scene.toml(), encoding="utf-8")
    began = os.times()
    command = [sys.executable, "-m", "contactlab.cli", "run", str(file), "--out", str(folder / "run")]
    subprocess.run(command, check=True, capture_output=True)
    ended = os.times()
    return ended.children_user + ended.children_system - began.children_user - began.children_system, 1


def by_turns(
    scenes: Mapping[str, Scene], rounds: int, spent: Callable[[Scene, Path], tuple[float, int]]
) -> dict[str, list[float]]:
    """Seconds of each kind of run, round after round, with the steps of a run."""
    times: dict[str, list[float]] = {kind: [] for kind in scenes}
    for number in range(rounds + 1):
        for kind, scene in scenes.items():
            with tempfile.TemporaryDirectory() as folder:
                seconds, steps = spent(scene, Path(folder))
            if number:
                times[kind].append(seconds)
    times["steps"] = [float(steps)]
    return times


def show(title: str, times: Mapping[str, list[float]], per_step: bool) -> None:
    """Print medians, and shares as medians of ratios within a round."""
    print(f"\n{title}: {median(times[NONE]):.3f} s without recorders")
    for kind in (kind for kind in times if kind not in (NONE, "steps")):
        shares = [with_it / without - 1.0 for with_it, without in zip(times[kind], times[NONE], strict=True)]
        added = median(times[kind]) - median(times[NONE])
        each = f", {1e6 * added / times['steps'][0]:6.1f} us per step" if per_step else ""
        print(f"  {kind:24s} +{added:.3f} s, {median(shares):6.1%} of a run{each}")


def first_look(scene: Scene, rounds: int) -> float:
    """CPU seconds of reading the results and making the recording from them, with the library imported."""
    recorder, times = default_registry().make("recorder", "rerun"), []
    with tempfile.TemporaryDirectory() as folder:
        simulate(scene, Path(folder) / "run")
        for _ in range(rounds + 1):
            began = process_time()
            record_again(recorder, Path(folder), load_results(Path(folder) / "run"))
            times.append(process_time() - began)
    return median(times[1:])


def level_report(level: int, rounds: int) -> None:
    """Measure and print one level."""
    scenes = {kind: load_scene("disc-on-block").with_({"level": level, **changes}) for kind, changes in KINDS.items()}
    times = by_turns(scenes, rounds, in_this_process)
    show(f"level {level}, in one process, {times['steps'][0]:.0f} steps", times, per_step=True)
    print(f"  the first look           {first_look(scenes[BOTH], rounds):.3f} s")
    some = {kind: scenes[kind] for kind in (NONE, BOTH, VIEW)}
    show(f"level {level}, as a command", by_turns(some, rounds, as_a_command), per_step=False)


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
