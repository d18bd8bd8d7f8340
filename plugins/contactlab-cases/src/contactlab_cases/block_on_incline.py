"""A block on an inclined plane: it slides by Coulomb's law, or does not move at all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, invariant, near
from contactlab_cases.dynamics import WORK, largest
from contactlab_cases.series import series, table

GRAVITY, ANGLE = 9810.0, math.radians(20.0)
BEGIN = 0.02  # s: after the weight has come and vibrations have gone
DOWN = (math.cos(ANGLE), -math.sin(ANGLE))
SPEED, STOP_MU = 100.0, 0.3
STOP = SPEED / (STOP_MU * GRAVITY)
LEVEL = {"bodies.block.rotate": 0.0, "rigid.plane.line": [[100.0, 0.0], [-20.0, 0.0]]}


@dataclass(frozen=True)
class BlockOnIncline(Case):
    """`mu` of the run that slides; one at 0.37, just above tan 20 = 0.364, must not move at all.

    The scene turned to a level plane must give the same path, and a block thrown along it stops after v/(mu g).
    `span` [s] is the time over which it is watched, after the weight has come; `cells` along the block, half as many
    across it. Of four, linear multipliers of the thrown block end at rest with a shear that alternates by 6 %, of six
    or more by less than the 5 % that are allowed.
    """

    mu: float = 0.3
    span: float = 0.05
    cells: int = 6

    title: ClassVar[str] = "block on an incline"
    source: ClassVar[str] = "Coulomb: a = g (sin 20 - mu cos 20)"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.1, 0.2, 0.3, 0.36), "cells": (4, 6)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "stick and slip"})
    swaps: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if not self.span > 0.0:
            raise ValueError(f"span: got {self.span}, allowed: a time > 0 s")
        if self.cells < 2 or self.cells % 2:
            raise ValueError(f"cells: got {self.cells}, allowed: an even number from 2 on")

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Four jobs: the block slides, stays at rest, slides in the scene turned level, and is thrown."""
        pull = [GRAVITY * math.sin(ANGLE), -GRAVITY * math.cos(ANGLE)]
        thrown = {
            **LEVEL, "bodies.block.velocity": [SPEED, 0.0], "effects.0.ramp": 0.0,
            "contacts.0.friction.mu": STOP_MU, "time.end": 1.5 * STOP,
        }  # fmt: skip
        return (
            self._job("sliding", setup, {"contacts.0.friction.mu": self.mu}),
            self._job("at rest", setup, {"contacts.0.friction.mu": 0.37}),
            self._job("turned", setup, {"contacts.0.friction.mu": self.mu, **LEVEL, "effects.0.acceleration": pull}),
            self._job("thrown", setup, thrown),
        )

    def _job(self, name: str, setup: Setup, changes: Mapping[str, Any]) -> Job:
        cells = [self.cells * setup.level, self.cells * setup.level // 2]
        base = {**setup.changes("block"), "bodies.block.mesh.cells": cells, "time.end": BEGIN + self.span}
        quantities = [f"{what}.block.{axis}" for what in ("displacement", "velocity") for axis in "xy"]
        watch = series("time", *quantities, every=3)
        return Job(name, "block-on-incline", {**base, **changes}, (watch,), work=WORK)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Ways and times against Coulomb's law, and how far a block at rest creeps."""
        exact = GRAVITY * (math.sin(ANGLE) - self.mu * math.cos(ANGLE))
        sticks = "a sticking node keeps its place but for round-off"
        why = f"vibrations of the start are a thousandth of the weight, over a time of {self.span:g} s"
        fraction = 0.005 * max(1.0, 600.0 / exact) * max(1.0, 0.05 / self.span)
        return (
            near(f"acceleration over {self.span:g} s", exact, fraction, why, "mm/s2"),
            at_most(f"creep at mu = 0.37 in {self.span:g} s", 1e-6, sticks, "mm"),
            invariant("path in the scene turned to a level plane", 1e-9, "independent of the axes: round-off"),
            near("time until a thrown block stops", STOP, 0.01, "v/(mu g); the block sways by a hundredth of it", "s"),
            at_most("creep after the stop", 1e-6, sticks, "mm"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures from motions of the block's centre of mass."""
        sliding, rest, turned, thrown = (table(done[name]) for name in ("sliding", "at rest", "turned", "thrown"))
        speed = _along(sliding, "velocity")
        late = sliding["time"] >= BEGIN
        gained = speed[-1] - speed[late][0]
        creep = _along(rest, "displacement")[rest["time"] >= BEGIN]
        way, level = _along(sliding, "displacement")[-1], turned["displacement.block.x"][-1]
        stopped = np.flatnonzero(thrown["velocity.block.x"] <= 0.0)
        after = thrown["displacement.block.x"][thrown["time"] >= 1.4 * STOP]
        return {
            f"acceleration over {self.span:g} s": float(gained / (sliding["time"][-1] - sliding["time"][late][0])),
            f"creep at mu = 0.37 in {self.span:g} s": largest(creep - creep[0]),
            "path in the scene turned to a level plane": float(abs(level / way - 1.0)),
            "time until a thrown block stops": float(thrown["time"][stopped[0]]) if len(stopped) else math.nan,
            "creep after the stop": largest(after - after[0]),
        }


def _along(found: Mapping[str, Any], what: str) -> Any:
    return DOWN[0] * found[f"{what}.block.x"] + DOWN[1] * found[f"{what}.block.y"]
