"""Does `friction-steps` know the error of the shear? Its estimate beside the true error, for docs/statics.md.

    python benchmarks/studies/friction_steps.py            # the table, against 320 load steps
    python benchmarks/studies/friction_steps.py 60         # so many scenes drawn at random, against 8 times the steps

The error is the difference of the slave's nodal shear forces over these forces, both as root of the sum of squares.
Runs with an error below 2 % and an estimate below the limit of 5 % are left out of the count: nothing is told there.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import contactlab
from contactlab.run import friction_error

STEPS, FINE = (5, 10, 20, 40), 320
FINER = 8
SEED = 5  # of a draw by which nothing of the estimate was chosen
SMALL, LIMIT, FACTOR = 0.02, friction_error.HIGH, 3.0
ALGORITHMS = ("mortar-p0", "mortar-p1", "mortar-dual", "node-on-segment")
Changes = Mapping[str, Any]


def pressed(algorithm: str, mu: float, **changes: Any) -> Changes:
    """The bundled disc on its block, at level 1 and with friction."""
    return {
        "level": 1, "integrator": "newton", "time.end": 1.0, "record.recorders": [],
        "contacts.0.algorithm": algorithm, "contacts.0.friction": {"use": "coulomb", "mu": mu},
        "supports.1.uy": {"ramp": "linear", "to": -0.1581}, **changes,
    }  # fmt: skip


AWAY = {"supports.1.uy": {"ramp": "linear", "to": -0.05}, "supports.1.ux": {"ramp": "linear", "to": 0.025}}
TABLE = {
    "disc on block, mu 0.2, `mortar-p1`": pressed("mortar-p1", 0.2),
    "the same, `node-on-segment`, block as slave": pressed("node-on-segment", 0.2, **{"contacts.0.swap": True}),
    "the same, mu 0.5, `mortar-p1`": pressed("mortar-p1", 0.5),
    "pressed and dragged at once, mu 0.6, `mortar-p1`": pressed("mortar-p1", 0.6, **AWAY),
    "the same, `node-on-segment`": pressed("node-on-segment", 0.6, **AWAY),
}


def drawn(seed: int, count: int) -> Iterator[tuple[str, Changes, int]]:
    """Discs pressed, dragged, or dragged to and fro, on elastic and yielding blocks; name, changes and steps."""
    draw = random.Random(seed)
    for _ in range(count):
        algorithm, mu, depth = draw.choice(ALGORITHMS), draw.choice((0.1, 0.2, 0.3, 0.5)), draw.uniform(0.02, 0.14)
        kind, steps = draw.choice(("press", "press", "drag", "drag", "turn", "plastic")), draw.choice((5, 10, 20))
        changes = {"contacts.0.swap": draw.random() < 0.4, "supports.1.uy": {"ramp": "linear", "to": -depth}}
        changes["materials.soft.young"] = draw.choice((3e3, 7e3, 3e4, 7e4))
        way = draw.uniform(0.005, 0.05)
        if kind in ("drag", "turn"):
            path = [[0.75, way], [1.0, -way]] if kind == "turn" else [[1.0, way]]
            for axis, points in (("uy", [[0.5, -depth], [1.0, -depth]]), ("ux", [[0.5, 0.0], *path])):
                changes[f"supports.1.{axis}"] = {"ramp": "table", "to": 1.0, "points": [[0.0, 0.0], *points]}
        if kind == "plastic":
            changes["materials.soft"] = {
                "use": "linear-hardening", "young": 7e3, "poisson": 0.3, "density": 2.7e-9, "hardening": 700.0,
                "yield_stress": draw.uniform(100.0, 500.0),
            }  # fmt: skip
        yield f"{kind}, {algorithm}, mu {mu}, {steps} steps", pressed(algorithm, mu, **changes), steps


def shear(changes: Changes, steps: int) -> tuple[np.ndarray, float]:
    """Shear forces of the slave's nodes (m,) [N], NaN if the run ended before, and the estimate of their error [-]."""
    scene = contactlab.load_scene("disc-on-block").with_({**changes, "integrator.steps": steps})
    try:
        results = contactlab.simulate(scene)
    except contactlab.ContactlabError:
        return np.array([np.nan]), np.nan
    told = [warning.value for warning in results.warnings if warning.code == "friction-steps"]
    curve = results.contact["contacts.0"].last
    forces = integrated(np.asarray(curve.s), np.asarray(curve.shear))
    return forces if results.status == "finished" else forces * np.nan, max(told, default=0.0)


def integrated(s: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Integrals of values (m,) at nodes along s (m,), linear in between, times the function of each node."""
    length = np.diff(s)
    out = np.zeros(len(s))
    out[:-1] += length * (values[:-1] / 3.0 + values[1:] / 6.0)
    out[1:] += length * (values[:-1] / 6.0 + values[1:] / 3.0)
    return out


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """Difference over the exact values, both as root of the sum of squares."""
    return float(np.linalg.norm(found - exact) / max(np.linalg.norm(exact), 1e-300))


def main(arguments: list[str]) -> None:
    """Print the table, or the scenes that were drawn and how many estimates are within the factor."""
    friction_error.HIGH = friction_error.PASSAGE = 1e-12  # estimates below the limit are told as well
    if not arguments:
        print("| scene | " + " | ".join(f"{n} steps" for n in STEPS) + " |")
        for name, changes in TABLE.items():
            exact, _ = shear(changes, FINE)
            pairs = [(error(found, exact), told) for found, told in (shear(changes, n) for n in STEPS)]
            print(f"| {name} | " + " | ".join(f"{100 * e:.2g} / {100 * t:.2g} %" for e, t in pairs) + " |", flush=True)
        return
    right = judged = 0
    for name, changes, steps in drawn(SEED, int(arguments[0])):
        (found, told), (exact, _) = shear(changes, steps), shear(changes, FINER * steps)
        true = error(found, exact)
        if not np.isfinite(true) or (true < SMALL and told < LIMIT):
            continue
        judged += 1
        right += true <= FACTOR * told and told <= FACTOR * true
        print(f"{name}: true {true:.1%}, told {told:.1%}", flush=True)
    print(f"{right} of {judged} estimates are within a factor of {FACTOR:g}")


if __name__ == "__main__":
    main(sys.argv[1:])
