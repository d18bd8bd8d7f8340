"""What a static solution costs from coarse meshes to fine, beside load steps, and what it errs by.

    python benchmarks/studies/nested_cost.py [LEVEL ...] [--rounds 3]

disc-on-block, deep, neo-Hookean, without friction: both mortars, either slave, by turns in one process. Seconds are CPU
seconds of the whole run, building and coarser levels included, compiling not; medians of the rounds with their spread.
"""

from __future__ import annotations

import argparse
import os
from statistics import median
from time import process_time
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[name] = "1"

import contactlab  # noqa: E402
from contactlab.results.results import Results  # noqa: E402
from contactlab.run.simulation import simulate  # noqa: E402
from contactlab.studies.measures import pressure_error  # noqa: E402
from contactlab.studies.profile import Profile  # noqa: E402
from contactlab.studies.reference import Reference, load_reference  # noqa: E402

WAYS: dict[str, Any] = {
    "nested": "newton",
    "5 load steps": {"use": "newton", "steps": 5},
    "explicit": "central-difference",
}
STEPS_UP_TO = 4  # levels above are solved nested alone


def timed(level: int, way: str, algorithm: str, swap: bool) -> tuple[float, Results]:
    """CPU seconds of a run without what it compiled or loaded, and its results."""
    keys = {"contacts.0.algorithm": algorithm, "contacts.0.swap": swap, "record.frames": 1}
    scene = contactlab.load_scene("disc-on-block").with_({"level": level, "integrator": WAYS[way]} | keys)
    began = process_time()
    results = simulate(scene)
    spent = process_time() - began
    assert results.status == "finished", results.reason
    return spent - results.summary["cost"]["compile_s"], results


def row(level: int, way: str, algorithm: str, swap: bool, rounds: int, reference: Reference) -> str:
    """A row of the table."""
    runs = [timed(level, way, algorithm, swap) for _ in range(rounds)]
    spent, results = [seconds for seconds, _ in runs], runs[-1][1]
    coarser = "+".join(str(of["iterations"]) for of in results.summary.get("nested", ()))
    error = pressure_error(Profile.of_curve(results.contact["contacts.0"].last), reference.profile, reference.window)
    return (
        f"| {level} | {way} | {algorithm}, {'block' if swap else 'disc'} | {results.summary['iterations']} "
        f"| {coarser} | {median(spent):.2f} ({min(spent):.2f} to {max(spent):.2f}) | {100.0 * error:.2f} % "
        f"| {results.summary['cost']['peak_memory_mib']:.0f} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("levels", nargs="*", type=int, default=[2, 4, 8])
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    reference = load_reference("disc-on-block-deep")
    print("| level | way | algorithm, slave | iterations | of coarser levels | CPU s | pressure, L2 | MiB |")
    print("|---|---|---|---|---|---|---|---|")
    for way in WAYS:
        timed(1, way, "mortar-p0", False)
    for level in options.levels:
        for algorithm in ("mortar-p0", "mortar-p1"):
            for swap in (False, True):
                for way in WAYS:
                    if way == "nested" or (way != "explicit" and level <= STEPS_UP_TO):
                        print(row(level, way, algorithm, swap, options.rounds, reference), flush=True)


if __name__ == "__main__":
    main()
