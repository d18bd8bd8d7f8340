"""Scenes that are wrong or strange in one or two keys: each must run, or be refused in words.

    python tests/abuse/fuzz.py [--scenes N] [--seed S] [--seconds S]

Prints the seed and a table; exit status 1 where there was a traceback or a hang over 20 s. Refusals that lack the key,
what was got or what is allowed are counted and shown.
"""

from __future__ import annotations

import argparse
import random
import signal
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import Any

from contactlab.errors import RequestError
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

SMALL = {
    "bodies.disc.mesh.cells": [6, 2], "bodies.block.mesh.cells": [8, 2], "time.end": 2e-6, "record.frames": 2,
    "record.recorders": [],
}  # fmt: skip
BASES: dict[str, dict[str, Any]] = {
    "explicit": SMALL,
    "friction": {**SMALL, "contacts.0.friction": {"use": "coulomb", "mu": 0.2}},
    "newton": {**SMALL, "integrator": "newton", "time.end": 1.0, "supports.1.uy.to": -0.01},
}
STRANGE: list[Any] = [
    0, -1, 1, 2, 3, 7, 10**9, 0.0, -0.0, 1e-300, 1e300, -1e-3, 0.1, 0.3, 0.4999, 0.5, 1.0, float("nan"), float("inf"),
    "", "x", "auto", "q1", "q2", "mortar-p1", "node-on-segment", "disc.arc", "block.top", "block.bottom", True, False,
    [], [0], [1, 1], [0.0, 1.0], [1.0, 0.0], [[0.0, 0.0], [1.0, 1.0]], {}, {"use": "nothing"}, "\u0000", "ü" * 50,
]  # fmt: skip
HANG = 20  # s of processor time


class Hung(BaseException):
    """A scene took too long."""


def keys(data: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """All dotted keys of a scene and what they hold."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else ()
    for name, value in items:
        inner = f"{place}.{name}" if place else str(name)
        yield inner, value
        yield from keys(value, inner)


def changed(value: Any, chance: random.Random) -> Any:
    """A strange value, or the present one a little or much off."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if number and chance.random() < 0.6:
        factor = chance.choice((0.5, 0.9, 1.1, 2.0, 1e-6, 1e6, -1.0))
        return type(value)(value * factor)
    return chance.choice(STRANGE)


def one(scene: Any, changes: dict[str, Any]) -> tuple[str, str, int]:
    """What comes of a scene with changes: how it ended, in words, and its steps."""
    signal.setitimer(signal.ITIMER_PROF, HANG)
    try:
        results = simulate(scene.with_(changes))
        return "ran", results.status, int(results.summary["steps"])
    except RequestError as error:
        told = str(error)
        whole = any(key.split(".")[0] in told for key in changes) and "  got " in told and "  allowed " in told
        return ("refused" if whole else "refused without key, got or allowed"), told, 0
    except Hung:
        return "over 20 s", "", 0
    except Exception as error:
        return "traceback", f"{type(error).__name__}: {error}", 0
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def hung(number: int, frame: Any) -> None:
    """The time of a scene is over."""
    raise Hung


def fuzz(scenes: int, seed: int, seconds: float, say: Any = print) -> Counter[str]:
    """Try so many scenes; counts by how they ended."""
    chance, counts, began = random.Random(seed), Counter[str](), time.process_time()
    warnings.simplefilter("ignore")
    before = signal.signal(signal.SIGPROF, hung)
    bases = [load_scene("disc-on-block").with_(changes) for changes in BASES.values()]
    places = [list(keys(base.data)) for base in bases]
    for _ in range(scenes):
        which = chance.randrange(len(bases))
        chosen = chance.sample(places[which], chance.choice((1, 1, 2)))
        changes = {place: changed(value, chance) for place, value in chosen}
        try:
            kind, words, steps = one(bases[which], changes)
        except KeyboardInterrupt:
            say("stopped")
            break
        counts[kind] += 1
        counts["past 20 steps"] += steps >= 20
        if kind not in ("ran", "refused"):
            say(f"{kind}: {list(BASES)[which]} {changes}\n    {words[:300]}")
        if time.process_time() - began > seconds:
            break
    signal.signal(signal.SIGPROF, before)
    return counts


def main() -> int:
    """Do it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1800.0, help="of processor time")
    asked = parser.parse_args()
    print(f"seed {asked.seed}", flush=True)
    counts = fuzz(asked.scenes, asked.seed, asked.seconds)
    print(dict(counts))
    return int(bool(counts["traceback"] or counts["over 20 s"]))


if __name__ == "__main__":
    sys.exit(main())
