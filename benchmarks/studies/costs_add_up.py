"""Do costs of effects add up: does a base cost plus the cost of each declared effect give what a step costs?

Six effects of one scene (a disc pressed into a soft block, which is squeezed from both sides as well, so that all of it
yields, with and without contact): contact, friction, finite strain, plasticity, gravity and
recording. Every valid subset is run, all in one process and side by side, some steps of each in turn; the cost of one
is its share in what all cost together in such a turn, so that a machine that others use, too, is the same machine for
all. CPU time, frames and files included, medians of rounds. The costs are those of the breakdown, one run
of the full scene for each effect taken out; where one effect needs another (friction contact, plasticity here finite
strain), the cost of the needed one is that of both less that of the other.

    python benchmarks/studies/costs_add_up.py [--rounds 5] [--steps 2000]
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from contactlab.model.build import build
from contactlab.run.folders import made_folder
from contactlab.run.guards import EVERY
from contactlab.run.prepare import prepare_run
from contactlab.scene.scene import Scene, load_scene

EFFECTS = ("contact", "friction", "finite strain", "plasticity", "gravity", "recording")
NEEDS = {"friction": "contact", "plasticity": "finite strain"}
DEPTH, SQUEEZE = -0.01, 0.02  # of the disc and of each side [mm]
SLICE = 25  # steps of a turn
MARGIN = 0.6  # of the stable step of the full scene
ELASTIC = {"young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
LAWS = {
    "small": {"use": "linear-elastic", **ELASTIC},
    "finite": {"use": "neo-hookean", **ELASTIC},
    "plastic": {"use": "linear-hardening", **ELASTIC, "yield_stress": 5.0, "hardening": 500.0},
}

Subset = frozenset[str]


def subsets() -> Iterator[Subset]:
    """All that hold with every effect the one that it needs."""
    for number in range(len(EFFECTS) + 1):
        for chosen in combinations(EFFECTS, number):
            if all(NEEDS.get(effect, effect) in chosen for effect in chosen):
                yield frozenset(chosen)


def scene_of(effects: Subset) -> Scene:
    """disc-on-block at level 2 with these effects and no other."""
    friction = {"use": "coulomb", "mu": 0.2} if "friction" in effects else None
    law = "plastic" if "plasticity" in effects else "finite" if "finite strain" in effects else "small"
    stiff = dict(LAWS["small" if law == "small" else "finite"], young=70000.0)
    changes: dict[str, Any] = {
        "level": 2, "supports": supports(), "time.damping": 0.0, "time.end": 1e-5, "record.frames": 5,
        "materials": {"steel": stiff, "soft": LAWS[law]}, "contacts.0.friction": friction,
        "record.recorders": ["vtkhdf"] if "recording" in effects else [],
    }  # fmt: skip
    if "gravity" in effects:
        changes["effects"] = [{"use": "gravity", "acceleration": [0.0, -9810.0]}]
    scene = load_scene("disc-on-block").with_(changes)
    return scene if "contact" in effects else scene.with_({"contacts": []})


def supports() -> list[dict[str, Any]]:
    """The disc comes down, the block is squeezed between its sides; so little that its law costs alike in all runs."""

    def driven(to: float) -> dict[str, Any]:
        return {"ramp": "linear", "to": to}

    return [
        {"on": "block.bottom", "uy": 0.0},
        {"on": "block.left", "ux": driven(SQUEEZE)},
        {"on": "block.right", "ux": driven(-SQUEEZE)},
        {"on": "disc.top", "ux": 0.0, "uy": driven(DEPTH)},
    ]


def timed(step: float, steps: int) -> Mapping[Subset, Scene]:
    """The same steps for all."""
    return {chosen: scene_of(chosen).with_({"time.step": step, "time.end": steps * step}) for chosen in subsets()}


class Slices:
    """One run that is made a few steps at a time, as the loop of a simulation makes them."""

    def __init__(self, scene: Scene, folder: Path) -> None:
        model = build(scene, scene.registry)
        self.run = prepare_run(model, scene, scene.registry, folder, resume=False)
        self.advance = model.bound_integrator().step
        self.run.store_start()
        self.samples = self.run.every_step

    def __call__(self, steps: int) -> float:
        """Make so many steps, frames included; CPU seconds."""
        run, began = self.run, process_time()
        for _ in range(steps):
            step = self.advance(run.schedule.dt)
            run.counts.steps += 1
            run.guards.after_step(step)
            for sample in self.samples:
                sample(step, run.schedule.dt)
            if run.counts.steps % EVERY == 0:
                run.guards.check()
            if run.schedule.frame_due():
                run.guards.check()
                run.store()
        return process_time() - began

    def end(self) -> None:
        """Close the files."""
        self.run.finish("finished", "")


def measured(scenes: Mapping[Subset, Scene], rounds: int, steps: int) -> dict[Subset, float]:
    """Cost of a step of every scene [us]: median over rounds of its share in what all of them cost together."""
    shares: dict[Subset, list[float]] = {chosen: [] for chosen in scenes}
    whole = []
    for number in range(rounds + 1):
        table = _one_round(scenes, steps)
        if number:  # the first round compiles
            totals = table.sum(axis=0)
            whole.append(totals.mean())
            for chosen, row in zip(scenes, table, strict=True):
                shares[chosen].append(float((row / totals).mean()))
    return {chosen: 1e6 * median(values) * median(whole) / SLICE for chosen, values in shares.items()}


def _one_round(scenes: Mapping[Subset, Scene], steps: int) -> np.ndarray:
    """CPU seconds (scenes, slices): all runs go on side by side, a slice of each in turn, in an order of chance."""
    chance = np.random.default_rng(1)
    table = np.zeros((len(scenes), steps // SLICE))
    with TemporaryDirectory() as folder:
        runs = [Slices(scene, made_folder(Path(folder) / str(n))) for n, scene in enumerate(scenes.values())]
        for turn in range(steps // SLICE):
            for number in chance.permutation(len(runs)):
                table[number, turn] = runs[number](SLICE)
        for run in runs:
            run.end()
    return table


def costs_of_effects(costs: Mapping[Subset, float]) -> dict[str, float]:
    """What each effect costs in the full scene, without what needs it."""
    found = {}
    for effect in EFFECTS:
        rest = frozenset(EFFECTS) - {other for other, needed in NEEDS.items() if needed == effect}
        found[effect] = costs[rest] - costs[rest - {effect}]
    return found


def study(rounds: int, steps: int) -> dict[str, Any]:
    """Costs of all subsets beside what the breakdown predicts."""
    full = scene_of(frozenset(EFFECTS))
    costs = measured(timed(MARGIN * build(full, full.registry).stable_step(), steps), rounds, steps)
    own, base = costs_of_effects(costs), costs[frozenset()]
    rows = []
    for chosen, spent in costs.items():
        predicted = base + sum(own[effect] for effect in chosen)
        names = [effect for effect in EFFECTS if effect in chosen]
        rows.append({"effects": names, "us": spent, "predicted_us": predicted, "error": predicted / spent - 1.0})
    return {"base_us": base, "effects_us": own, "subsets": rows, "worst": max(abs(row["error"]) for row in rows)}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--json", type=Path, help="write everything to this file, too")
    chosen = parser.parse_args()
    found = study(chosen.rounds, chosen.steps)
    print(f"nothing declared: {found['base_us']:.1f} us of CPU time per step")
    for effect, own in found["effects_us"].items():
        print(f"  {effect:14s} {own:+7.1f} us")
    print(f"{'measured':>9s} {'predicted':>9s} {'error':>7s}")
    for row in found["subsets"]:
        print(f"{row['us']:9.1f} {row['predicted_us']:9.1f} {row['error']:+7.1%}  {', '.join(row['effects']) or '-'}")
    print(f"worst of {len(found['subsets'])} subsets: {found['worst']:.1%}")
    if chosen.json is not None:
        chosen.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
