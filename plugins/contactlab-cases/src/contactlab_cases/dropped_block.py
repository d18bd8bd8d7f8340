"""A soft block that bounces until it rests, and one that is pressed and released many times.

Forces of the mortar methods act along normals averaged on the slave. Next to a released node they lean, so
that they work on what slides there: energy may rise a little, by an amount of first order in the segment length.
Node-on-segment takes the normal of the plane, and keeps the energy to round-off. Consistent forces never add any,
which is checked; frozen forces have no such bound, so the energy that they add is reported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, invariant, near, reported, within
from contactlab_cases.dynamics import WORK, pushed

WEIGHT = 1e-9 * 10.0 * 10.0 * 9810.0  # N
FALL = 0.5  # mm
GAIN = "largest rise of energy in a step"
TAKES = "contact never adds energy: round-off"


def _energy(name: str, forces: str) -> Measure:
    return invariant(name, 1e-9, TAKES) if forces == "consistent" else reported(name)


@dataclass(frozen=True)
class DroppedBlock(Case):
    """10 x 10, E = 0.05, dropped from 0.5 mm."""

    fall: float = FALL
    forces: str = "consistent"

    title: ClassVar[str] = "dropped block"
    source: ClassVar[str] = "energy and equilibrium"
    family: ClassVar[str] = "rest"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"fall": (0.25, 0.5, 1.0), "forces": ("consistent", "frozen")}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    proves: ClassVar[frozenset[str]] = frozenset({"rest", "energy"})
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job, whose last fifth is taken as rest."""
        changes = {
            **setup.changes("block"), "bodies.block.mesh.cells": [5 * setup.level, 4 * setup.level],
            "bodies.block.shift": [0.0, self.fall], "contacts.0.enforcement": pushed(self.forces),
        }  # fmt: skip
        return (Job("dropped", "dropped-block", changes, ("contact-changes",), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Measure the block at rest, and the energy that contact has made."""
        return (
            near("force at rest", WEIGHT, 1e-3, "vibrations have died", "N"),
            _energy(f"{GAIN} over that of the fall", self.forces),
            at_most("largest pull of a contact node over the weight", 0.0, "nodal forces push"),
            at_most("changes per 100 steps at rest", 1.0, "no endless opening and closing"),
            reported("conditions that opened or closed before rest"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Normalise by the energy of the fall, and the weight."""
        found = done["dropped"].watched["contact-changes"]
        changes, last = found["changes"], len(found["changes"]) // 5
        return {
            "force at rest": float(found["push"][-1]),
            f"{GAIN} over that of the fall": _gain(found) / (WEIGHT * self.fall),
            "largest pull of a contact node over the weight": max(0.0, float(found["pull"].max()) / WEIGHT),
            "changes per 100 steps at rest": 100.0 * float(changes[-last:].sum()) / last,
            "conditions that opened or closed before rest": float(changes[:-last].sum()),
        }


@dataclass(frozen=True)
class PressedBlock(Case):
    """The top goes down by 0.2 below touching and up by as much above it, slowly, `cycles` times."""

    cycles: int = 10
    forces: str = "consistent"

    title: ClassVar[str] = "pressed again and again"
    source: ClassVar[str] = "energy"
    family: ClassVar[str] = "rest"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"cycles": (10, 20), "forces": ("consistent", "frozen")}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    proves: ClassVar[frozenset[str]] = frozenset({"rest", "energy"})
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job, whose last fifth is taken as rest."""
        points = _zigzag(self.cycles)
        top = {"on": "block.top", "ux": 0.0, "uy": {"ramp": "table", "to": -0.2, "points": points}}
        changes = {
            **setup.changes("block"), "bodies.block.shift": [0.0, 0.0], "effects": [], "supports": [top],
            "bodies.block.mesh.cells": [5 * setup.level, 4 * setup.level],
            "contacts.0.enforcement": pushed(self.forces),
            "time.end": points[-1][0], "time.damping": 1000.0, "time.step": 1e-4 / setup.level,
        }  # fmt: skip
        return (Job("pressed", "dropped-block", changes, ("contact-changes",), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """All cycles are equal, and no energy comes from contact."""
        return (
            at_most("largest force, change from the second to the last", 1e-3, "damped vibrations of the first cycle"),
            _energy(f"{GAIN} over that stored", self.forces),
            within("changes of contact per node and cycle", 1.9, 2.1, "closed and opened once"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate forces at the lowest point of each cycle."""
        found, step = done["pressed"].watched["contact-changes"], 1e-4 / setup.level
        forces = [float(found["push"][int(p[0] / step) - 1]) for p in _zigzag(self.cycles)[1::2]]
        nodes = 5 * setup.level + 1
        return {
            "largest force, change from the second to the last": abs(forces[-1] / forces[1] - 1.0),
            f"{GAIN} over that stored": _gain(found) / float(found["work.internal"].max()),
            "changes of contact per node and cycle": float(found["changes"].sum()) / self.cycles / nodes,
        }


def _zigzag(cycles: int, period: float = 0.01) -> list[list[float]]:
    return [[0.0, 0.0]] + [[(i + 0.5) * 0.5 * period, 1.0 if i % 2 == 0 else -1.0] for i in range(2 * cycles)]


def _gain(found: Mapping[str, Any]) -> float:
    return max(0.0, float(np.diff(found["work.contact"], prepend=0.0).max()))
