"""Is one checkout slower than another? CPU times of two by turns, as ratios of pairs.

    python benchmarks/by_turns.py BEFORE AFTER                     # two checkouts, each with its own .venv
    python benchmarks/by_turns.py BEFORE AFTER --only contact --pairs 15

Each measurement is a process of its own in its checkout: where a process happens to lie in memory makes it faster or
slower by a tenth as long as it lives. Every pair is measured in the other order than the one before. So what loads the
machine loads both, and the ratio of a pair tells more than the quotient of two times. Printed are the median ratio
AFTER : BEFORE and its 95 % interval, by drawing the pairs anew a few thousand times. Models are those of each
checkout's own `benchmarks/kernels/steps.py`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

PAIRS, DRAWS = 15, 4000
FEWER = {"cold compilation": 3}  # pairs of what takes long
START = "import contactlab; contactlab.simulate(contactlab.load_scene('disc-on-block').with_({'time.end': 1e-8}))"
STATIC = """
import contactlab
from time import process_time
changes = {"level": 4, "integrator": {"use": "newton", "steps": 2}, "supports.1.uy.to": -0.005}
scene = contactlab.load_scene("disc-on-block").with_({**changes, "record.recorders": []})
began = process_time()
contactlab.simulate(scene)
print(process_time() - began)
"""
ONE_THREAD = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def measures() -> dict[str, Callable[[], float]]:
    """CPU seconds of one measurement by name, in the environment of a checkout."""
    return {
        "element loop": lambda: _elements(5000),
        "contact step level 2": lambda: _contact(2),
        "contact step level 8": lambda: _contact(8),
        "contact step, 300 nodes pressed": _pressed,
        "static level 4": _static,
        "cached start": lambda: _start({}),
        "cold compilation": _cold,
    }


def _steps() -> Any:
    sys.path.insert(0, str(Path.cwd() / "benchmarks" / "kernels"))
    import steps

    return steps


def _elements(cells: int) -> float:
    """Of two pressed blocks, six times as wide as high."""
    steps = _steps()
    height = max(1, round((cells / 12.0) ** 0.5))
    return _spent(steps.blocks(6 * height, height, "mortar-p0"), "elements", 60, 100)


def _pressed() -> float:
    """Of two pressed blocks of one layer of cells."""
    return _spent(_steps().blocks(299, 1, "mortar-p0"), "contact", 100, 100)


def _contact(level: int) -> float:
    """Of disc-on-block with a given damping: what `auto` damps may differ from one version to the other."""
    import contactlab

    changes = {"level": level, "supports.1.uy.duration": 1e-6, "time.end": 1.0, "time.damping": 1e5}
    scene = contactlab.load_scene("disc-on-block").with_(changes)
    return _spent(scene, "contact", 400 // level, 800 // level)


def _spent(scene: Any, phase: str, warm: int, number: int) -> float:
    """CPU seconds of a phase in the median of nine rounds. Numbers of steps are given: both do the same steps."""
    steps = _steps()
    model = steps.build(scene, scene.registry)
    dt = 0.9 * model.stable_step()
    clock = steps.Clock(model)
    known = hasattr(model, "bound_integrator")
    advance = model.bound_integrator().step if known else model.integrator.bind(model, model.state)
    found = []
    for count in (warm, *[number] * 9):
        clock.spent[phase] = 0.0
        for _ in range(count):
            advance(dt)
        found.append(clock.spent[phase])
    return float(np.median(found[1:]))


def _static() -> float:
    """In a process of its own: a second run in one process first gives back the memory of the first."""
    told = subprocess.run([sys.executable, "-c", STATIC], check=True, stdout=subprocess.PIPE, text=True)
    return float(told.stdout.split()[-1])


def _start(environment: dict[str, str]) -> float:
    before = os.times()
    subprocess.run(
        [sys.executable, "-c", START], check=True, stdout=subprocess.DEVNULL, env={**os.environ, **environment}
    )
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def _cold() -> float:
    with tempfile.TemporaryDirectory() as cache:
        return _start({"CONTACTLAB_CACHE": cache})


def measured(root: Path, name: str) -> float:
    """CPU seconds of one measurement in a checkout: ratios alone count."""
    command = [str(root.resolve() / ".venv" / "bin" / "python"), str(Path(__file__).resolve()), "--measure", name]
    environment = {**os.environ, **ONE_THREAD}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # modules are kept compiled, as where they are installed
    told = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, text=True, env=environment)
    if told.returncode:
        raise SystemExit(f"{name}: the process in {root} ended with {told.returncode}")
    return float(told.stdout.split()[-1])


def ratios(before: Path, after: Path, name: str, pairs: int) -> list[float]:
    """AFTER : BEFORE of each pair; a first one, which compiles, is left out."""
    found: list[float] = []
    for pair in range(pairs + 1):
        order = (before, after) if pair % 2 else (after, before)
        times = {root: measured(root, name) for root in order}
        if pair:
            found.append(times[after] / times[before])
    return found


def interval(found: Sequence[float]) -> tuple[float, float]:
    """95 % interval of the median."""
    draws = np.random.default_rng(1).choice(np.asarray(found), (DRAWS, len(found)))
    low, high = np.quantile(np.median(draws, axis=1), (0.025, 0.975))
    return float(low), float(high)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkouts", nargs="*", type=Path, metavar="CHECKOUT", help="before and after")
    parser.add_argument("--only", default="", help="measurements with this in their names")
    parser.add_argument("--pairs", type=int, help=f"pairs of each ({PAIRS}, fewer of what takes long)")
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.measure:
        print(measures()[chosen.measure]())
        return 0
    if len(chosen.checkouts) != 2:
        parser.error("two checkouts, please: the one before and the one after")
    before, after = chosen.checkouts
    for name in (name for name in measures() if chosen.only in name):
        found = ratios(before, after, name, chosen.pairs or FEWER.get(name, PAIRS))
        low, high = interval(found)
        print(f"{name:34s} {np.median(found):.3f}  (95 % {low:.3f} to {high:.3f}, {len(found)} pairs)", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
