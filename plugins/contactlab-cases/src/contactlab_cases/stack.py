"""Blocks upon each other that come under their weight slowly, and then lie still."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, reported
from contactlab_cases.dynamics import WORK, largest
from contactlab_cases.series import series, table

SIDE, GRAVITY = 10.0, 9810.0  # mm, mm/s2
WEIGHT = 1e-9 * SIDE * SIDE * GRAVITY  # N, of a block
SEGMENTS = (3, 4, 5)
RAMP, REST = 0.05, 0.02  # s


@dataclass(frozen=True)
class Stack(Case):
    """`blocks` with 3, 4 and 5 segments in turn. The same with bodies and contacts in another order gives the same."""

    blocks: int = 4

    title: ClassVar[str] = "stack at rest"
    source: ClassVar[str] = "equilibrium"
    family: ClassVar[str] = "rest"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"blocks": (2, 4, 8)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    proves: ClassVar[frozenset[str]] = frozenset({"rest", "many contacts"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan the stack at rest, and again in another order; both until the same time, so that steps agree."""
        return self._job("stack", setup), self._job("reordered", setup, turned=True)

    def _job(self, name: str, setup: Setup, turned: bool = False) -> Job:
        numbers = list(range(self.blocks))
        bodies = {f"block{k}": self._block(k, setup) for k in (reversed(numbers) if turned else numbers)}
        contacts = [self._contact(k, setup) for k in numbers]
        scene = {
            "name": "stack", "time": {"end": RAMP + REST * setup.level}, "integrator": setup.integrator,
            "materials": {"rubber": {"use": "neo-hookean", "young": 10.0, "poisson": 0.3, "density": 1e-9}},
            "bodies": bodies, "rigid": {"floor": {"line": [[2.0 * SIDE, 0.0], [-SIDE, 0.0]]}},
            "contacts": contacts[1::2] + contacts[::2] if turned else contacts,
            "effects": [
                {"use": "gravity", "acceleration": [0.0, -GRAVITY], "ramp": RAMP},
                {"use": "vibration-damping", "rate": 5e3},
            ],
        }  # fmt: skip
        forces = series("kinetic", "sweeps", *(f"{what}.block{k}.{axis}" for k in numbers for what, axis in PLACES),
                        begin_time=RAMP)  # fmt: skip
        return Job(name, scene, watch=(forces,), work=WORK)

    def _block(self, k: int, setup: Setup) -> dict[str, Any]:
        cells = [SEGMENTS[k % 3] * setup.level, 3 * setup.level]
        mesh = {"use": "rectangle", "x": [0.0, SIDE], "y": [k * SIDE, (k + 1) * SIDE], "cells": cells}
        return {"element": setup.element, "material": "rubber", "mesh": mesh}

    def _contact(self, k: int, setup: Setup) -> dict[str, Any]:
        """A block on the one below it; the floor is never the slave."""
        sides = {"slave": f"block{k}.bottom", "master": f"block{k - 1}.top" if k else "floor"}
        return sides | {"algorithm": setup.algorithm, "swap": setup.swap and k > 0}

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Forces against the weights above, and how much any motion grows."""
        return (
            at_most("force under each block, largest error", 1e-3, "the weight comes in 40 periods of the stack"),
            at_most("sideways drift in segments", 1e-6, "no force acts sideways: round-off", "h"),
            at_most("kinetic energy of the second half over that of the first", 1.05, "damped vibrations die"),
            at_most("another order, largest change of a force", 3e-7, "the sweeps end at 1e-10 of a segment"),
            reported("sweeps per step"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Force under every block, by its number: what carries it and all above it."""
        found = table(done["stack"])
        forces, other = (self._forces(table(done[name])) for name in ("stack", "reordered"))
        kinetic, half = found["kinetic"], len(found["kinetic"]) // 2
        drift = [found[f"displacement.block{k}.x"] for k in range(self.blocks)]
        wanted = WEIGHT * np.arange(self.blocks, 0, -1)
        return {
            "force under each block, largest error": largest(forces.mean(axis=1) / wanted - 1.0),
            "sideways drift in segments": max(largest(d - d[0]) for d in drift) * 3.0 / SIDE,
            "kinetic energy of the second half over that of the first": float(
                kinetic[half:].mean() / kinetic[:half].mean()
            ),
            "another order, largest change of a force": largest(forces / other - 1.0),
            "sweeps per step": float(found["sweeps"].mean()),
        }

    def _forces(self, found: Mapping[str, Floats]) -> Floats:
        own = np.array([found[f"force.block{k}.y"] for k in range(self.blocks)])
        return np.cumsum(own[::-1], axis=0)[::-1]


PLACES = (("force", "y"), ("displacement", "x"))
