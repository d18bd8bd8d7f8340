"""Scenes with one, two or three keys changed: mildly, to another part, or to something strange."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from contactlab.model import sizes
from contactlab.scene.scene import load_scene

SMALL = {
    "bodies.disc.mesh.cells": [6, 2], "bodies.block.mesh.cells": [8, 2], "time.end": 2e-6, "record.frames": 2,
    "record.recorders": [],
}  # fmt: skip
STATIC = {**SMALL, "integrator": {"use": "newton", "steps": 24}, "time.end": 1.0, "supports.1.uy.to": -0.01}
COULOMB = {"use": "coulomb", "mu": 0.2}
BASES: dict[str, dict[str, Any]] = {
    "explicit": SMALL,
    "friction": {**SMALL, "contacts.0.friction": COULOMB},
    "segments, plasticity": {
        **SMALL, "contacts.0.algorithm": "node-on-segment",
        **{f"materials.soft.{key}": value for key, value in {
            "use": "power-law", "strength": 348.0, "prestrain": 0.02, "exponent": 0.03,
        }.items()},
    },
    "quadratic": {
        **SMALL, "bodies.disc.element": "q2", "bodies.block.element": "q2-lagrange",
        "contacts.0.algorithm": "mortar-p1",
    },
    "newton": STATIC,
    "newton, friction": {**STATIC, "contacts.0.friction": COULOMB},
    "implicit-dynamics": {**SMALL, "integrator": {"use": "implicit-dynamics", "steps": 24}, "time.end": 2e-6},
}  # fmt: skip
WEIGHTS = {"newton": 1, "newton, friction": 1, "implicit-dynamics": 1}  # others 3: a run of theirs costs a quarter
STRANGE: list[Any] = [
    0, -1, 1, 2, 3, 7, 10**9, 0.0, -0.0, 1e-300, 1e300, -1e-3, 0.1, 0.3, 0.4999, 0.5, 1.0, float("nan"), float("inf"),
    "", "x", "auto", "q1", "q2", "mortar-p1", "node-on-segment", "disc.arc", "block.top", "block.bottom", True, False,
    [], [0], [1, 1], [0.0, 1.0], [1.0, 0.0], [[0.0, 0.0], [1.0, 1.0]], {}, {"use": "nothing"}, "\u0000", "ü" * 50,
]  # fmt: skip
FACTORS = (0.5, 0.9, 1.1, 2.0, 1e-6, 1e6, -1.0)
MILD = (0.7, 0.9, 0.98, 1.02, 1.1, 1.3)


def keys(data: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """All dotted keys of a scene and what they hold."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else ()
    for name, value in items:
        inner = f"{place}.{name}" if place else str(name)
        yield inner, value
        yield from keys(value, inner)


class Scenes:
    """The scenes that are changed, and their keys."""

    def __init__(self, names: tuple[str, ...] = tuple(BASES)) -> None:
        self.bases = {name: load_scene("disc-on-block").with_(BASES[name]) for name in names}
        self.weights = [WEIGHTS.get(name, 3) for name in names]
        self.places = {name: list(keys(base.data)) for name, base in self.bases.items()}
        self.numbers = {name: [(k, v) for k, v in places if _number(v)] for name, places in self.places.items()}

    def wrong(self, chance: random.Random) -> tuple[str, dict[str, Any]]:
        """A base and one or two changes, most of them wrong."""
        (name,) = chance.choices(list(self.bases), self.weights)
        chosen = chance.sample(self.places[name], chance.choice((1, 1, 2)))
        return name, {place: changed(value, chance) for place, value in chosen}

    def large(self, chance: random.Random, machine: float) -> tuple[str, dict[str, Any]]:
        """A base at a level at which it takes from a tenth of the machine's memory to more than it has."""
        (name,) = chance.choices(list(self.bases), self.weights)
        base, level, wanted = self.bases[name], 1, chance.uniform(0.1, 1.3) * machine
        while sizes.estimated_bytes(base.with_({"level": level}), base.registry) < wanted:
            level += 1
        return name, {"level": level}

    def mild(self, chance: random.Random) -> tuple[str, dict[str, Any]]:
        """A base and one to three numbers that are a little off: most of these run."""
        (name,) = chance.choices(list(self.bases), self.weights)
        chosen = chance.sample(self.numbers[name], chance.choice((1, 2, 3)))
        return name, {place: type(value)(value * chance.choice(MILD)) for place, value in chosen}


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def changed(value: Any, chance: random.Random) -> Any:
    """A strange value, or the present one a little or much off."""
    if _number(value) and chance.random() < 0.6:
        return type(value)(value * chance.choice(FACTORS))
    return chance.choice(STRANGE)
