"""What recording costs: every step's scalars, the results file and the timeline, against the step that is recorded.

A run of disc-on-block is made without recorders and stepped again with its sampler at work; then everything that it
stored is given to a recording, call by call as in a run. Times are those of the thread that steps ("blocked") and of
the whole process ("CPU": compression goes on in threads of its own). The best of some rounds counts: shares of a step
then compare what a quiet machine would do.

    python benchmarks/kernels/recording.py                # levels 1 and 2 of disc-on-block
    python benchmarks/kernels/recording.py --levels 1 2 4
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter, process_time, thread_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from contactlab.api import Step
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.results.step_columns import step_columns
from contactlab.results.steps import BLOCK, StepSampler
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

ROUNDS = 7
SAMPLES = 20_000
MICRO = 1e6
BAR_SCALARS = 2.0  # microseconds per step
BAR_SHARE = 0.02  # of the step


class Cost:
    """Seconds of this thread and of the whole process between two moments."""

    def __init__(self) -> None:
        self.thread, self.process = thread_time(), process_time()

    def spent(self) -> np.ndarray:
        """Both (2,) so far."""
        return np.array([thread_time() - self.thread, process_time() - self.process])


def measured(work: Callable[..., Any], *arguments: Any) -> np.ndarray:
    """What a call costs (2,)."""
    cost = Cost()
    work(*arguments)
    return cost.spent()


def sampling(level: int) -> float:
    """Seconds per step of sampling all scalars into the buffer."""
    scene = load_scene("disc-on-block").with_({"level": level})
    model = build(scene, default_registry())
    dt = 0.9 * model.stable_step()
    advance = model.bound_integrator().step
    for _ in range(50):  # so that there are rows
        step: Step = advance(dt)
    columns = len(step_columns([s.on for s in model.loading.supports], [pair.name for pair in model.contact.pairs]))
    sampler = StepSampler(model, columns, lambda block: None)
    sample = sampler.sample
    rounds = []
    for _ in range(ROUNDS):
        began = thread_time()
        for _ in range(SAMPLES):
            sample(step, dt)
        rounds.append((thread_time() - began) / SAMPLES)
    return min(rounds)


def recorded(name: str, run: Results) -> dict[str, Any]:
    """Costs (blocked, CPU) of opening, of all steps, of all frames and of closing one recording."""
    recorder = default_registry().make("recorder", name)
    frames, steps = list(run.frames), np.concatenate(list(run.step_blocks()))
    ends = [0, *(frame.step for frame in frames), len(steps)]
    rounds = []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            cost = {}
            began = Cost()
            recording = recorder.open(Path(folder), run.layout)
            cost["open"] = began.spent()
            cost["steps"] = cost["frames"] = np.zeros(2)
            for number, frame in enumerate(frames):
                rows = steps[ends[number] : frame.step]
                cost["steps"] = cost["steps"] + measured(hand_over, recording, rows)
                cost["frames"] = cost["frames"] + measured(recording.frame, frame)
            cost["close"] = measured(recording.close, run.summary)
            rounds.append(cost)
    return {what: np.min([cost[what] for cost in rounds], axis=0) for what in rounds[0]}


def hand_over(recording: Any, rows: np.ndarray) -> None:
    """Steps as the sampler gives them."""
    for begin in range(0, len(rows), BLOCK):
        recording.steps(rows[begin : begin + BLOCK])


def level_report(level: int) -> dict[str, Any]:
    """All figures of one level, times per step in microseconds."""
    scene = load_scene("disc-on-block").with_({"level": level})
    with tempfile.TemporaryDirectory() as folder:
        run = simulate(scene.with_({"record.recorders": ["vtkhdf"]}), Path(folder) / "run")
        bare = min(bare_step(scene) for _ in range(2))
        count = run.summary["steps"]
        report: dict[str, Any] = {"level": level, "steps": count, "frames": len(run.frames), "step": bare * MICRO}
        report["sampling"] = sampling(level) * MICRO
        for name in ("vtkhdf", "rerun"):
            cost = recorded(name, run)
            report[name] = {what: (value / count * MICRO).tolist() for what, value in cost.items()}
            report[name]["all"] = sum(np.array(value) for value in report[name].values()).tolist()
    return report


def bare_step(scene: Any) -> float:
    """CPU seconds of a step without recorders, the first one left out."""
    cost = simulate(scene.with_({"record.recorders": []})).summary
    return (cost["cost"]["run_cpu_s"] - cost["cost"]["compile_s"]) / cost["steps"]


def start_up() -> dict[str, float]:
    """Seconds that importing the libraries of the recorders takes in a fresh interpreter, once per process."""
    found = {}
    for name in ("h5py", "rerun"):
        code = f"import numpy, time; t = time.process_time(); import {name}; print(time.process_time() - t)"
        runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True) for _ in range(3)]
        found[name] = median(float(run.stdout) for run in runs)
    return found


def show(report: dict[str, Any]) -> None:
    """Print the figures of a level."""
    step, bar = report["step"], max(BAR_SCALARS, BAR_SHARE * report["step"])
    print(f"\nlevel {report['level']}: {report['steps']} steps of {step:.0f} us, {report['frames']} frames")
    print(f"  sampling all scalars         {report['sampling']:6.2f} us per step")
    print("  us per step, blocked (CPU)     open          steps         frames        close         all")
    for name in ("vtkhdf", "rerun"):
        cells = "".join(f"{blocked:6.2f} ({cpu:5.2f})" for blocked, cpu in report[name].values())
        print(f"  {name:27s} {cells}")
    scalars = report["sampling"] + report["rerun"]["steps"][0]
    verdict = _met(scalars, BAR_SCALARS)
    print(f"  every step's scalars on the timeline: {scalars:.2f} us per step, bar {BAR_SCALARS:.0f}: {verdict}")
    for number, what in enumerate(("blocked", "CPU")):
        whole = report["sampling"] + report["rerun"]["all"][number]
        share = f"{whole:.2f} us = {whole / step:.1%} of a step"
        print(f"  the whole timeline, {what}: {share}, bar {bar:.1f}: {_met(whole, bar)}")


def _met(value: float, bar: float) -> str:
    return "met" if value <= bar else "missed"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--levels", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    options = parser.parse_args()
    began = perf_counter()
    imports = start_up()
    print("imports, once per process: " + ", ".join(f"{name} {seconds:.2f} s" for name, seconds in imports.items()))
    reports = []
    for level in options.levels:
        reports.append(level_report(level))
        show(reports[-1])
    if options.json:
        options.json.write_text(json.dumps({"imports": imports, "levels": reports}, indent=1))
    print(f"\n{perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
