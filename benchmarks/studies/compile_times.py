"""How long a combination of parts that was never run before takes to compile, and how soon a known one steps.

A cache with everything that disc-on-block needs is made first; every combination then begins with a copy of that, in a
process of its own. What is printed is the CPU time up to the end of the third step less that of disc-on-block, which
compiles nothing; wall times are not taken, since others may use the machine. `benchmarks/bench.py --only compilation`.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ELASTIC = {"young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
FRICTION = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
COMBINATIONS: dict[str, dict[str, Any]] = {
    "linear-elastic": {"materials.soft.use": "linear-elastic"},
    "hypoelastic": {"materials.soft.use": "hypoelastic"},
    "linear-hardening": {
        "materials.soft": {"use": "linear-hardening", **ELASTIC, "yield_stress": 0.01, "hardening": 500.0}
    },
    "power-law": {
        "materials.soft": {"use": "power-law", **ELASTIC, "strength": 0.01, "prestrain": 0.02, "exponent": 0.1}
    },
    "q1-fbar": {"bodies.block.element": "q1-fbar"},
    "q1-reduced": {"bodies.block.element": "q1-reduced"},
    "q2": {"bodies.block.element": "q2"},
    "q2-lagrange": {"bodies.block.element": "q2-lagrange"},
    "mortar-p1": {"contacts.0.algorithm": "mortar-p1"},
    "node-on-segment": {"contacts.0.algorithm": "node-on-segment"},
    "friction": FRICTION,
    "no contact": {"contacts": []},
    "gravity": {"effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}]},
    "newton": {"integrator": "newton"},
    "newton with friction": {"integrator": "newton", **FRICTION},
}

PROGRAM = """
import json, sys, tempfile, time
changes = json.loads(sys.argv[1])
from contactlab.scene.scene import load_scene
scene = load_scene("disc-on-block").with_({"time.end": 1e-6, **changes})
if scene.integrator["use"] == "newton":
    scene = scene.with_({"time.step": 1e-7})
from contactlab.model.build import build
from contactlab.run.prepare import prepare_run
from pathlib import Path
with tempfile.TemporaryDirectory() as folder:
    model = build(scene, scene.registry)
    run = prepare_run(model, scene, scene.registry, Path(folder), resume=False)
    advance = model.bound_integrator().step
    run.store_start()
    for _ in range(3):
        step = advance(run.schedule.dt)
        for sample in run.every_step:
            sample(step, run.schedule.dt)
print(time.process_time())
"""


def cpu(changes: Mapping[str, Any], cache: Path) -> float:
    """CPU seconds of a fresh process until its third step."""
    environment = {**os.environ, "CONTACTLAB_CACHE": str(cache), "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    command = [sys.executable, "-c", PROGRAM, json.dumps(changes)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return float(done.stdout.split()[-1])


def study(only: str = "") -> dict[str, Any]:
    """CPU seconds: everything anew, a known scene, and what each combination adds to that."""
    with TemporaryDirectory() as folder:
        known = Path(folder) / "known"
        everything = cpu({}, known)
        again = min(cpu({}, known) for _ in range(3))
        rows = {}
        for name, changes in COMBINATIONS.items():
            if only in name:
                cache = Path(shutil.copytree(known, Path(folder) / "own"))
                rows[name] = max(0.0, cpu(changes, cache) - again)
                shutil.rmtree(cache)
    return {"everything_s": everything, "known_s": again, "combinations_s": rows}
