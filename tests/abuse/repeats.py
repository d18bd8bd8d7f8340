"""Many runs with the default recorders in one process: threads and memory must not grow.

    python tests/abuse/repeats.py [--runs N]

Prints both while it goes on; exit status 1 if after the first 20 runs threads were added, or more than 50 MiB.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

SMALL = {
    "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.end": 2e-6, "record.frames": 5,
}  # fmt: skip
FIRST = 20  # runs after which the library and its allocators have what they need
ALLOWED = 50.0  # MiB


def threads() -> int:
    """Threads of this process, those of its libraries among them."""
    return len(list(Path("/proc/self/task").iterdir()))


def resident() -> float:
    """MiB of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20


def main() -> int:
    """Do it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    runs = parser.parse_args().runs
    scene = load_scene("disc-on-block").with_(SMALL)
    first: tuple[int, float] | None = None
    with tempfile.TemporaryDirectory() as folder:
        for number in range(1, runs + 1):
            simulate(scene, Path(folder) / f"run-{number}")
            if number == FIRST:
                first = threads(), resident()
            if number in (1, FIRST) or not number % 50:
                print(f"{number} runs: {threads()} threads, {resident():.1f} MiB", flush=True)
    return int(first is not None and (threads() > first[0] or resident() > first[1] + ALLOWED))


if __name__ == "__main__":
    sys.exit(main())
