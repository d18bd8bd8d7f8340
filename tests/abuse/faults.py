"""Kills at random moments, full disks and damaged files: what is stored must be whole, or said not to be.

    python tests/abuse/faults.py [--kills N] [--disks N] [--damages N] [--seed S]

Prints the seed and a table; exit status 1 where a number came back that was not stored, or a traceback.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "timeline")]

from damages import damage, everything, outcome, same  # noqa: E402
from test_kill import ForkServer  # noqa: E402
from test_resume import COULOMB, IMPLICIT, PLASTIC, STATICS  # noqa: E402

import contactlab  # noqa: E402

SMALL = {
    "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.end": 8e-6, "record.frames": 20,
    "record.recorders": ["vtkhdf"],
}  # fmt: skip
VARIANTS: dict[str, dict[str, Any]] = {
    "mortar-p0": {},
    "mortar-p1, friction": {"contacts.0.algorithm": "mortar-p1", **COULOMB},
    "node-on-segment, plasticity": {"contacts.0.algorithm": "node-on-segment", **PLASTIC},
    "quadratic": {"bodies.disc.element": "q2", "bodies.block.element": "q2-lagrange"},
    "newton": STATICS,
    "newton, friction": {**STATICS, **COULOMB},
    "implicit-dynamics, plasticity": {**IMPLICIT, **PLASTIC},
}
TABLES = ("history.csv", "contact.csv", "iterations.csv")
GOOD = ("same", "killed too early or too late", "as before", "told", "told, some salvaged", "full, then same")


def kill(fork_server: ForkServer, scene: Any, whole: Path, cpu: float, folder: Path, chance: random.Random) -> str:
    """Kill a run once or twice, take it up again, and compare everything."""
    hit = False
    for attempt in range(chance.choice((1, 1, 2))):
        ended = fork_server.run(scene, folder, resume=attempt > 0, lives=chance.uniform(0.1, 0.9) * cpu)
        hit = hit or ended.status < 0
    if fork_server.run(scene, folder, resume=True).status != 0:
        return "not taken up"
    return _compared(whole, folder, "same" if hit else "killed too early or too late")


def fill_disk(fork_server: ForkServer, scene: Any, whole: Path, folder: Path, chance: random.Random) -> str:
    """Let no file become larger than a share of what the run needs, then take the run up again."""
    size = (whole / "results.vtkhdf").stat().st_size
    fork_server.run(scene, folder, largest=int(chance.uniform(0.02, 1.0) * size))
    if fork_server.run(scene, folder, resume=True).status != 0:
        return "not taken up"
    return _compared(whole, folder, "full, then same")


def _compared(whole: Path, folder: Path, good: str) -> str:
    if not same(everything(folder), everything(whole)):
        return "other numbers"
    for name in TABLES:
        if (whole / name).is_file() and (whole / name).read_bytes() != (folder / name).read_bytes():
            return f"{name} differs"
    return good


def main() -> int:
    """Do it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name, number in (("kills", 300), ("disks", 20), ("damages", 300), ("seed", 1)):
        parser.add_argument(f"--{name}", type=int, default=number)
    asked = parser.parse_args()
    print(f"seed {asked.seed}", flush=True)
    chance, counts = random.Random(asked.seed), {"kills": Counter(), "disks": Counter(), "damages": Counter()}
    root, fork_server = Path(tempfile.mkdtemp()), ForkServer()
    whole: dict[str, tuple[Any, Path, float]] = {}
    for name, changes in VARIANTS.items():
        if len(whole) == max(asked.kills, asked.disks, asked.damages):
            break  # fewer tries than kinds of runs
        scene = contactlab.load_scene("disc-on-block").with_({**SMALL, **changes})
        done = fork_server.run(scene, root / name)
        assert done.status == 0, f"{name} does not run by itself"
        whole[name] = scene, root / name, done.cpu
    for kind, number in (("kills", asked.kills), ("disks", asked.disks), ("damages", asked.damages)):
        for count in range(number):
            name = list(whole)[count % len(whole)]
            scene, place, cpu = whole[name]
            folder = root / "try"
            if kind == "kills":
                came = kill(fork_server, scene, place, cpu, folder, chance)
            elif kind == "disks":
                came = fill_disk(fork_server, scene, place, folder, chance)
            else:
                folder.mkdir()
                shutil.copy(place / "results.vtkhdf", folder)
                damage(folder / "results.vtkhdf", chance)
                came = outcome(folder, everything(place))
            counts[kind][came] += 1
            if not (count + 1) % 50:
                print(kind, dict(counts[kind]), flush=True)
            if came not in GOOD:
                print(f"{kind} {count}, {name}: {came}", flush=True)
            shutil.rmtree(folder)
        print(kind, dict(counts[kind]), flush=True)
    fork_server.close()
    shutil.rmtree(root)
    return int(any(came not in GOOD for counter in counts.values() for came in counter))


if __name__ == "__main__":
    sys.exit(main())
