"""What a run takes outside its steps: CPU time and memory, by how it goes through time and whether it is recorded.

Imports and kernels make nearly all of it, and follow from these two. It is measured in processes of their own.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from contactlab.errors import RequestError
from contactlab.prices.counts import recorders_in
from contactlab.prices.samples import FILE
from contactlab.scene.scene import Scene

TIMES = 3
FRAMES = 20


def start_kind(scene: Scene) -> str:
    """How a scene is run, as starts are told apart: "explicit", "load steps, recorded" ..."""
    inertia = scene.registry.part_class("integrator", scene.integrator["use"]).inertia
    return ("explicit" if inertia else "load steps") + (", recorded" if recorders_in(scene) else "")


def start_of(scene: Scene, known: Mapping[str, float]) -> float:
    """The value for a scene; that of the dearest kind where its own was not measured."""
    return known.get(start_kind(scene), max(known.values()))


def measured_starts(base: Scene, times: int = TIMES) -> tuple[dict[str, float], dict[str, float]]:
    """CPU time [s] and memory [MiB] of the starts of all kinds of runs of the scene that prices are measured with."""
    seconds, memory = {}, {}
    for changes in _kinds(base):
        kind = start_kind(base.with_(changes))
        runs = [_whole_run(changes) for _ in range(times)]
        seconds[kind], memory[kind] = (median(values) for values in zip(*runs, strict=True))
    return seconds, memory


def _kinds(base: Scene) -> Iterator[dict[str, Any]]:
    registry = base.registry
    names = registry.names("integrator")
    static = [name for name in names if not registry.part_class("integrator", name).inertia]
    for integrator in (base.integrator["use"], *static[:1]):
        for record in ({"frames": FRAMES}, {"frames": FRAMES, "recorders": []}):
            yield {"integrator": integrator, "record": record}


def _whole_run(changes: Mapping[str, Any]) -> tuple[float, float]:
    """CPU time [s] and memory [MiB] of a run in a process of its own, without its steps and arrays."""
    with TemporaryDirectory() as folder:
        words = [sys.executable, "-P", "-c", _FAR_END, str(FILE), str(Path(folder) / "run"), json.dumps(changes)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            last = done.stderr.strip().splitlines()[-1:] or ["no word"]
            raise RequestError(f"a run in a process of its own failed: {last[0]}")
    spent, cost = json.loads(done.stdout.splitlines()[-1])
    steps = cost["run_cpu_s"] - cost["compile_s"]
    return spent - steps, cost["peak_memory_mib"] - cost["arrays_mib"]


_FAR_END = """
import json, sys, time
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene
results = simulate(load_scene(sys.argv[1]).with_(json.loads(sys.argv[3])), out=sys.argv[2])
print(json.dumps([time.process_time(), results.summary["cost"]]))
"""
