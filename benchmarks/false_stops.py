"""Which runs do guards stop in error? Bundled scenes and cases with every element and either slave.

    python benchmarks/false_stops.py                          # all bundled scenes
    python benchmarks/false_stops.py --work 20000 disc stack  # longer, those whose name has one of these words
    python benchmarks/false_stops.py --friction 0.2 disc      # runs with friction have another pace
    python benchmarks/false_stops.py --cases hertz ironing    # the first runs of cases

A run that is stopped is made again without guards. The stop is in error if that run comes to the same point as the
runs of the same scene that were not stopped: its status, the energy that contact made, and its largest reaction tell.
Runs end after `--work` steps and iterations; what guards stop in error they stop early, while little energy is there.
Prints one row a run and exits with 1 if a stop is in error.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from functools import partial
from statistics import median
from typing import Any

import contactlab
from contactlab.api import Setup
from contactlab.cases.run_case import scene_of
from contactlab.errors import ContactlabError
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, bundled_scenes

ELEMENTS = ("q2", "q1", "q2-lagrange", "q1-reduced", "q1-fbar")
ENDED = ("finished", "timed-out")
ROUND = 1e-9  # N/mm: less is no force
FORCE = 0.05  # of the median of the scene's runs
MADE = 0.1  # of the largest energy: what guards allow contact to make


Asked = tuple[str, str, bool, Callable[[], Scene]]
"""Name, element, side and scene of a run, which may be refused."""


def scenes(words: list[str], mu: float | None) -> Iterator[Asked]:
    """Yield the runs of bundled scenes, element by element, with the friction of their own or of `mu`."""
    for element in ELEMENTS:
        for name in sorted(bundled_scenes()):
            if words and not any(word in name for word in words):
                continue
            scene = contactlab.load_scene(name)
            bodies = {f"bodies.{body}.element": element for body in scene.data["bodies"]}
            for swap in (False, True):
                sides: dict[str, Any] = {}
                for k in range(len(scene.data.get("contacts", ()))):
                    sides[f"contacts.{k}.swap"] = swap
                    if mu is not None:
                        sides[f"contacts.{k}.friction"] = {"use": "coulomb", "mu": mu}
                yield name, element, swap, partial(scene.with_, {**bodies, **sides, "record.recorders": []})


def jobs(words: list[str]) -> Iterator[Asked]:
    """Yield the first runs of cases, with the first of their integrators."""
    registry = default_registry()
    for name in registry.names("case"):
        if words and not any(word in name for word in words):
            continue
        case = registry.make("case", name)
        for element in case.elements:
            for swap in (False, True):
                setup = Setup("mortar-dual", swap, element, case.integrators[0])
                for job in case.plan(setup, {}):
                    if job.guards:
                        yield f"{name} {job.name}", str(element), swap, partial(scene_of, job, registry)


def numbers(results: Any) -> tuple[float, float]:
    """Largest reaction, and the energy that contact made over the largest of all energies and works."""
    summary = results.summary
    forces = [abs(value) for force in summary["reactions"].values() for value in force]
    energies = {name: abs(value) for name, value in summary["balance"].items() if isinstance(value, float)}
    made = max(0.0, float(summary["balance"].get("contact") or 0.0))
    return max(forces, default=0.0), made / max([*energies.values(), 1e-300])


def main() -> int:
    """Make the runs and print the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="parts of names")
    parser.add_argument("--cases", action="store_true", help="cases instead of bundled scenes")
    parser.add_argument("--work", type=float, default=2500, help="steps and iterations of a run")
    parser.add_argument("--friction", type=float, metavar="MU", help="Coulomb friction in every contact of scenes")
    options = parser.parse_args()
    asked = jobs(options.words) if options.cases else scenes(options.words, options.friction)
    forces: dict[str, list[float]] = {}
    stopped: list[tuple[str, str, str]] = []
    count = 0
    for name, element, swap, make in asked:
        side = "exchanged" if swap else "as declared"
        try:
            scene = make()
            results = contactlab.simulate(scene, work=options.work)
        except ContactlabError as error:
            print(f"| {name} | {element} | {side} | refused | {str(error).splitlines()[0]} |", flush=True)
            continue
        count += 1
        force, made = numbers(results)
        print(f"| {name} | {element} | {side} | {results.status} | {force:.5g}, contact made {made:.2%} |", flush=True)
        if results.status in ENDED:
            if results.status == "finished" and force > ROUND:
                forces.setdefault(name, []).append(force)
            continue
        free = contactlab.simulate(scene, work=options.work, guards=False)
        force, made = numbers(free)
        known = forces.get(name) if free.status == "finished" else None
        apart = abs(force - median(known)) / max(median(known), 1e-300) if known else float("nan")
        same = free.status in ENDED and made <= MADE and not apart > FORCE
        verdict = "in error" if same else "right"
        stopped.append((name, verdict, results.reason))
        print(
            f"|  | stopped {verdict} | without guards {free.status} | {force:.5g}, {apart:.1%} apart, contact made "
            f"{made:.2%} | {results.reason[:150]} |",
            flush=True,
        )
    wrong = sum(verdict == "in error" for _, verdict, _ in stopped)
    print(f"{count} runs, {len(stopped)} stopped, {wrong} in error")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
