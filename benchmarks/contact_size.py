"""How a contact grows with its number of segments: build, step and memory, each size in a process of its own.

    python benchmarks/contact_size.py [--segments 2500 10000 40000] [--steps 20] [--contact mortar-p0 node-on-segment]

Prints processor seconds of the build and of a step (without compilation), the peak of memory beside what libraries
take, and each per segment: where these stay the same, time and memory are linear.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from time import process_time
from typing import Any

SMALLEST = 100  # segments of the run that loads kernels and libraries
ROWS = 2  # of cells beneath each surface


def scene_of(segments: int, contact: str) -> Any:
    """A flat block pressed on another all along, with so many segments on either side, of different lengths."""
    from contactlab.scene.scene import load_scene

    return load_scene("disc-on-block").with_({
        "contacts.0.algorithm": contact, "contacts.0.slave": "disc.bottom", "symmetry": None,
        "bodies.disc.mesh": {"use": "rectangle", "x": [-0.8, 0.8], "y": [0.0, 0.6], "cells": [segments, ROWS]},
        "bodies.block.mesh.cells": [segments, ROWS], "time.end": 1.0, "record.recorders": [], "record.frames": 1,
    })  # fmt: skip


def measure(segments: int, contact: str, steps: int) -> dict[str, float]:
    """Build and run in this process."""
    from contactlab.model.build import build
    from contactlab.results.peak_memory import peak_memory_mib, reset_peak
    from contactlab.run.simulation import simulate

    simulate(scene_of(SMALLEST, contact), work=2)
    scene = scene_of(segments, contact)
    reset_peak()
    before = peak_memory_mib()
    began = process_time()
    model = build(scene, scene.registry)
    built = process_time() - began
    integrator = model.bound_integrator()
    integrator.step(model.stable_step())  # the search begins with nothing
    began = process_time()
    for _ in range(steps):
        integrator.step(model.stable_step())
    return {"build": built, "step": (process_time() - began) / steps, "memory": peak_memory_mib() - before}


def main() -> None:
    """Measure all sizes, one process after the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--segments", type=int, nargs="+", default=[2500, 10_000, 40_000])
    parser.add_argument("--contact", nargs="+", default=["mortar-p0", "mortar-p1", "node-on-segment"])
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.one:
        print(json.dumps(measure(asked.segments[0], asked.contact[0], asked.steps)))
        return
    print("| contact | segments | build [CPU s] | step [CPU ms] | memory [MiB] | of a segment [us, us, KiB] |")
    print("|---|---|---|---|---|---|")
    for contact in asked.contact:
        for segments in asked.segments:
            command = [sys.executable, str(Path(__file__)), "--one", "--steps", str(asked.steps)]
            command += ["--segments", str(segments), "--contact", contact]
            found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            build, step, memory = found["build"], 1e3 * found["step"], found["memory"]
            each = [1e6 * found["build"], 1e6 * found["step"], 1024.0 * found["memory"]]
            print(
                f"| {contact} | {segments} | {build:.2f} | {step:.2f} | {memory:.0f} | "
                f"{', '.join(f'{one / segments:.3g}' for one in each)} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
