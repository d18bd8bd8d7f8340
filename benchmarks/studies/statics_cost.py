"""What a static solution costs beside GetFEM's on the same meshes: CPU seconds and pressure errors.

    apt-get install python3-getfem
    python benchmarks/studies/statics_cost.py [LEVEL ...] [--rounds 5] [--python /usr/bin/python3]

disc-on-block, neo-Hookean, without friction: shallow in one load step, deep in five. Codes take turns in one process
tree, one thread each; medians of the rounds. Seconds are those of the load steps alone: meshes, models and compiling
are not counted, recording ours is. GetFEM runs with its best solver, MUMPS, and two orders of integration of its
contact, the finer of which is what its accuracy needs. Pressures are measured against the bundled references over their
own windows. `--python` is an interpreter that has GetFEM.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[name] = "1"

import contactlab  # noqa: E402
from contactlab.run.simulation import simulate  # noqa: E402
from contactlab.studies.measures import pressure_error  # noqa: E402
from contactlab.studies.profile import Profile  # noqa: E402
from contactlab.studies.reference import Reference, load_reference  # noqa: E402

PEER = Path(__file__).parents[1] / "peers" / "getfem_disc_on_block.py"
CASES = {"shallow": (0.01, 1), "deep": (0.1581, 5)}
Row = dict[str, Any]


def ours(algorithm: str, swap: bool) -> Callable[[int, float, int], Row]:
    """A run of contactlab."""

    def run(level: int, depth: float, steps: int) -> Row:
        scene = contactlab.load_scene("disc-on-block").with_(
            {
                "level": level,
                "integrator": {"use": "newton", "steps": steps},
                "contacts.0.algorithm": algorithm,
                "contacts.0.swap": swap,
                "supports.1.uy.to": -depth,
                "record.frames": 1,
            }
        )
        results = simulate(scene)
        assert results.status == "finished", results.reason
        curve = results.contact["contacts.0"].last
        return {
            "x": curve.x,
            "pressure": curve.pressure,
            "reaction": results.summary["reactions"]["block.bottom"][1],
            "iterations": results.summary["iterations"],
            "seconds": results.summary["cost"]["run_cpu_s"],
        }

    return run


def getfem(python: str, slave: str, quadrature: int) -> Callable[[int, float, int], Row]:
    """A run of GetFEM."""

    def run(level: int, depth: float, steps: int) -> Row:
        command = [python, str(PEER), "--json", "--level", str(level), "--depth", str(depth), "--steps", str(steps)]
        command += ["--slave", slave, "--quadrature", str(quadrature)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return {"failed": (done.stderr or done.stdout).strip().splitlines()[-1]}
        return dict(json.loads(done.stdout.splitlines()[-1]))

    return run


def codes(python: str) -> dict[str, Callable[[int, float, int], Row]]:
    """Everything that takes a turn."""
    found = {}
    for slave, swap in (("disc", False), ("block", True)):
        for algorithm in ("mortar-p0", "mortar-p1"):
            found[f"{algorithm}, {slave} slave"] = ours(algorithm, swap)
        for quadrature in (3, 9):
            found[f"GetFEM, {slave} slave, order {quadrature}"] = getfem(python, slave, quadrature)
    return found


def error(row: Row, reference: Reference) -> float:
    """Relative L2 error of the pressure."""
    return pressure_error(Profile.of_nodes(*_arrays(row)), reference.profile, reference.window)


def _arrays(row: Row) -> tuple[Any, Any]:
    import numpy as np

    return np.asarray(row["x"], float), np.nan_to_num(np.asarray(row["pressure"], float))


def main() -> None:
    """A table per level and depth."""
    wish = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    wish.add_argument("levels", type=int, nargs="*", default=[2, 4, 8])
    wish.add_argument("--rounds", type=int, default=5)
    wish.add_argument("--python", default="/usr/bin/python3")
    given = wish.parse_args()
    chosen = codes(given.python)
    # whatever compiles is compiled before
    for name, run in chosen.items():
        if not name.startswith("GetFEM"):
            run(1, 0.01, 1)
    for case, (depth, steps) in CASES.items():
        reference = load_reference(f"disc-on-block-{case}")
        for level in given.levels:
            rows: dict[str, list[Row]] = {name: [] for name in chosen}
            for _ in range(given.rounds):
                for name, run in chosen.items():
                    rows[name].append(run(level, depth, steps))
            show(case, level, rows, reference)


def show(case: str, level: int, rows: dict[str, list[Row]], reference: Reference) -> None:
    """Print a table, ratios to the fastest peer that is solved last."""
    good = {name: found for name, found in rows.items() if "failed" not in found[0]}
    seconds = {name: median(row["seconds"] for row in found) for name, found in good.items()}
    peers = {name: value for name, value in seconds.items() if name.startswith("GetFEM")}
    best = min(peers.values(), default=float("nan"))
    print(f"\n{case}, level {level}\n| code | iterations | CPU s | over the best peer's | pressure, L2 | reaction |")
    print("|---|---|---|---|---|---|")
    wanted = reference.scalar("reaction")
    for name, found in rows.items():
        if name not in good:
            print(f"| {name} | {found[0]['failed']} |  |  |  |  |")
            continue
        row, off = found[0], abs(abs(found[0]["reaction"]) / wanted - 1.0)
        print(
            f"| {name} | {row['iterations']} | {seconds[name]:.3f} | {seconds[name] / best:.2f} "
            f"| {100.0 * error(row, reference):.2f} % | {100.0 * off:.3f} % |",
            flush=True,
        )


if __name__ == "__main__":
    main()
