"""A block on a spring that slides on a floor: every half swing is shorter by 2 mu m g/k, until friction holds it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error
from contactlab_cases.dynamics import WORK
from contactlab_cases.series import series, table

WIDTH, HEIGHT, DENSITY, YOUNG, GRAVITY = 10.0, 2.0, 1e-9, 1.0, 9810.0  # mm, t/mm3, MPa, mm/s2
PERIOD = 0.1  # s, of the block on its spring: fifty of its own longest vibrations
MASS = DENSITY * WIDTH * HEIGHT


@dataclass(frozen=True)
class SpringFriction(Case):
    """`mu`; `swings`: the block is thrown so that it turns back so many times before friction holds it.

    From x = 0 with speed v: x1 = -d + (d^2 + (v/w)^2)^(1/2), d = mu g/w^2, then x_(n+1) = -(x_n - 2 d); it stays where
    |x| < d.
    """

    mu: float = 0.2
    swings: int = 3

    title: ClassVar[str] = "block on a spring with friction"
    source: ClassVar[str] = "Den Hartog 1931, Mechanical Vibrations: Coulomb friction"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.1, 0.2), "swings": (3, 8)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "stick and slip"})
    swaps: ClassVar[bool] = False

    @property
    def _d(self) -> float:
        return self.mu * GRAVITY * (PERIOD / (2.0 * math.pi)) ** 2

    def _turns(self) -> list[float]:
        """Places where the block turns back [mm]; it stays at the last one."""
        return [(-1) ** k * (2.0 * (self.swings - k) - 1.5) * self._d for k in range(self.swings)]

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: thrown from the spring's rest, with its full weight from the start."""
        w = 2.0 * math.pi / PERIOD
        speed = w * math.sqrt((self._turns()[0] + self._d) ** 2 - self._d**2)
        n = 5 * setup.level
        mesh = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, HEIGHT], "cells": [n, setup.level]}
        block = {"material": "m", "element": setup.element, "mesh": mesh, "velocity": [speed, 0.0]}
        law = {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}
        scene = {
            "name": "spring-friction", "time": {"end": (0.5 * self.swings + 0.5) * PERIOD},
            "integrator": setup.integrator,
            "materials": {"m": law}, "bodies": {"block": block},
            "rigid": {"floor": {"line": [[1000.0, 0.0], [-1000.0, 0.0]], "segment": 100.0}},
            "contacts": [
                {
                    "slave": "block.bottom", "master": "floor", "algorithm": setup.algorithm,
                    "friction": {"use": "coulomb", "mu": self.mu},
                }
            ],
            "effects": [
                {"use": "gravity", "acceleration": [0.0, -GRAVITY]},
                {"use": "spring", "on": "block", "stiffness": [MASS * w**2, 0.0]},
            ],
        }  # fmt: skip
        return (Job("thrown", scene, watch=(series("time", "displacement.block.x", every=2),), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The weight acts suddenly: the block bounces a little on its own stiffness, and the mean carries."""
        why = "a sudden weight makes the pressure oscillate about the right mean"
        return (
            error("first turning point", 0.03, why),
            error("place where it stays, over d", 0.15, f"half of what {self.swings} swings add up to; {why}"),
            error("time of the first turn over that of a quarter swing and its lag", 0.02, why),
            at_most("creep after the last turn over d", 1e-3, "a sticking node keeps its place"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the rigid block."""
        found, turns, d = table(done["thrown"]), self._turns(), self._d
        time, x = found["time"], found["displacement.block.x"]
        first = int(np.argmax(x[time < 0.4 * PERIOD]))
        phase = math.acos(d / (turns[0] + d))  # of x = -d + (x1 + d) cos(w t - phase)
        last = x[time > (0.5 * self.swings + 0.25) * PERIOD]
        return {
            "first turning point": float(x[first]) / turns[0] - 1.0,
            "place where it stays, over d": (float(last[-1]) - turns[-1]) / d,
            "time of the first turn over that of a quarter swing and its lag": float(time[first])
            / (phase * PERIOD / (2.0 * math.pi))
            - 1.0,
            "creep after the last turn over d": float(np.ptp(last)) / d,
        }
