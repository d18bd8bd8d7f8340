"""A million explicit steps of a disc that bounces in a box, with no damping and no gravity.

    python benchmarks/studies/million_steps.py [--forces conjugate] [--cells 12x3] [algorithm ...]

Energy must never rise above that of the start, momentum must be what the walls gave, and the disc must stay inside.
`cells` is 8x2 or 12x3. Rows of one mesh, algorithm and kind of forces each are kept in million_steps.csv;
case_pages.py puts them into build/docs/hard-cases.md.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import process_time

import kept_rows
import numpy as np

from contactlab.scene.scene import load_scene
from contactlab.testing.cases.watched import WatchedRun

STORED = Path(__file__).with_name("million_steps.csv")
KEYS = ("cells", "algorithm", "forces")
ALGORITHMS = ("mortar-p0", "mortar-p1", "node-on-segment")
STEPS = 1_000_000
BOX = 2.0  # mm, half its side
EVERY = 100  # steps between looks at the stored energy


def bounce(algorithm: str, cells: str, forces: str, steps: int) -> dict[str, float | str]:
    """The run and what was seen of it."""
    scene = load_scene("disc-in-box").with_(
        {
            "contacts.0.algorithm": algorithm,
            "contacts.0.enforcement": {"use": "forward-increment", "forces": forces},
            "bodies.disc.mesh.cells": [int(n) for n in cells.split("x")],
            "time.end": 1.0,
        }
    )
    run = WatchedRun(scene)
    own, force, work = run.nodes("disc"), run.state["contact_force"], run.state["work"]
    start, momentum, stored = run.energy(), run.momentum(), 0.0
    impulse, impacts, closed, rise, highest, outside = np.zeros(2), 0, False, 0.0, 0.0, 0.0
    given, taken = 0.0, 0.0
    spread, before, began, last = 0.0, 0.0, process_time(), 0.0
    for number in range(steps):
        dt = run.dt
        run.step()
        pushed = force[own].sum(axis=0)
        # velocities live between the steps: a force acts for half of the step before and half of this one
        impulse += 0.5 * (last + dt) * pushed
        last = dt
        impacts += bool(pushed.any()) and not closed
        closed = bool(pushed.any())
        change, before = float(work[3]) - before, float(work[3])
        rise, given, taken = max(rise, change), given + max(change, 0.0), taken - min(change, 0.0)
        if number % EVERY == EVERY - 1:
            stored = run.energy() - run.model.kinetic_energy()
        if number % EVERY == 0:
            highest = max(highest, _energy(run, stored) / start - 1.0)
            outside = max(outside, float(np.abs(run.model.position[own]).max()) - BOX)
            spread = max(spread, float(np.abs(run.momentum() - momentum - impulse).max()))
    scale = run.model.mass.sum() * float(np.hypot(3000.0, 2000.0))
    speed = np.hypot(*run.mean(run.state["velocity"], "disc"))
    return {
        "cells": cells,
        "algorithm": algorithm,
        "forces": forces,
        "steps": steps,
        "time [s]": run.time,
        "impacts": impacts,
        "energy above the start, at most": highest,
        "energy in the end": run.energy() / start,
        "given by contact, in all steps where it gives": given / start,
        "taken by contact, in all others": taken / start,
        "largest rise in a step": rise / start,
        "momentum not given by walls": spread / scale,
        "farthest outside the box [mm]": outside,
        "speed in the end [mm/s]": float(speed),
        "energy lost per impact": (1.0 - run.energy() / start) / max(1, impacts),
        "mass of an arc node": float(run.model.mass[run.contact.pairs[0].slave.nodes].mean() / run.model.mass.sum()),
        "CPU per step [us]": 1e6 * (process_time() - began) / steps,
    }


def _energy(run: WatchedRun, stored: float) -> float:
    """Kinetic energy, and the energy stored half a step before and after; `stored` is that of the step before."""
    kinetic = run.model.kinetic_energy()
    return kinetic + 0.5 * (stored + run.energy() - kinetic)


def store(row: dict[str, str]) -> None:
    """Put a row into the table, in the place of one of the same mesh, algorithm and forces."""
    rows = [old for old in kept_rows.read(STORED) if any(old[key] != row[key] for key in KEYS)]
    kept_rows.write(STORED, list(row), [*rows, row])


def main() -> None:
    """Run and store one row after the other."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("algorithm", nargs="*", default=ALGORITHMS)
    arguments.add_argument("--cells", choices=("8x2", "12x3"), default="12x3")
    arguments.add_argument("--forces", choices=("consistent", "frozen"), default="frozen")
    given = arguments.parse_args()
    for algorithm in given.algorithm:
        row = bounce(algorithm, given.cells, given.forces, STEPS)
        store({key: f"{v:.4g}" if isinstance(v, float) else str(v) for key, v in row.items()})
    print(STORED.read_text())


if __name__ == "__main__":
    main()
