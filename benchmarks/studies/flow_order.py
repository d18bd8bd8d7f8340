"""Plastic flow in load steps: error by the number of steps and CPU seconds, beside an explicit run.

    python benchmarks/studies/flow_order.py [TURNS]

disc-on-block, level 1, mortar-p0, deep, the block of the power law. Errors are those of the end against 160 load steps.
"alone" is the law by itself: one implicit Euler step a load step. Medians of TURNS (3) runs by turns in one process,
each of its own; CPU seconds of the whole run without compiling, least to largest in brackets.
"""

from __future__ import annotations

import sys
from statistics import median
from time import process_time

import numpy as np
from contactlab_solids.power_law import PowerLaw

import contactlab
from contactlab.results.results import Results

SOFT = {
    "use": "power-law", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9, "strength": 348.0, "prestrain": 0.02,
    "exponent": 0.03,
}  # fmt: skip
CASES = (*((steps, along) for along in (False, True) for steps in (10, 20, 30, 40, 80)), (0, True))


def run(steps: int, along: bool) -> tuple[float, Results]:
    """CPU seconds and results; no steps: explicit."""
    keys = {"level": 1, "contacts.0.algorithm": "mortar-p0", "record.frames": 1, "record.recorders": []}
    scene = contactlab.load_scene("disc-on-block").with_({**keys, "materials.soft": SOFT})
    if steps:
        scene = scene.with_({"integrator": {"use": "newton", "steps": steps}})
    PowerLaw.implicit_euler = along
    began = process_time()
    results = contactlab.simulate(scene)
    return process_time() - began, results


def main() -> None:
    """Print the table."""
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    _, exact = run(160, True)
    run(10, False), run(0, True)  # compile
    pressure = exact.contact["contacts.0"].last.pressure
    force = exact.summary["reactions"]["block.bottom"][1]
    seconds: dict[tuple[int, bool], list[float]] = {case: [] for case in CASES}
    told = {}
    for _ in range(turns):
        for case in CASES:
            spent, results = run(*case)
            seconds[case].append(spent)
            error = np.linalg.norm(results.contact["contacts.0"].last.pressure - pressure) / np.linalg.norm(pressure)
            told[case] = (results.summary["reactions"]["block.bottom"][1] / force - 1.0, error, results.summary)
    print("| steps | iterations | CPU s | reaction | pressure, L2 |\n|---|---|---|---|---|")
    for (steps, along), spent in seconds.items():
        reaction, error, summary = told[steps, along]
        name = f"{steps}{'' if along else ', law alone'}" if steps else f"explicit, {summary['steps']}"
        print(
            f"| {name} | {summary['iterations'] if steps else ''} | {median(spent):.2f} ({min(spent):.2f} to "
            f"{max(spent):.2f}) | {100 * reaction:+.3f} % | {100 * error:.2f} % |"
        )


if __name__ == "__main__":
    main()
