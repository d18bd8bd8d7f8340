"""A block that swings on a spring over a smooth floor for very many steps: what leapfrog keeps, it keeps for ever.

It is one cell, whose nodes have one mass and one share of the spring each, so that it swings as one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.series import series, table

WIDTH, HEIGHT, DENSITY, YOUNG, GRAVITY = 2.0, 1.0, 1e-9, 1.0, 9810.0  # mm, t/mm3, MPa, mm/s2
MASS = DENSITY * WIDTH * HEIGHT
SWING = 1.0  # mm
ROWS = 4000
STEP = 0.3 * HEIGHT * math.sqrt(DENSITY / YOUNG)  # s: three tenths of what a wave takes through the cell


@dataclass(frozen=True)
class LongRun(Case):
    """`steps` in all, `turn` of them in a period of the spring.

    A step of leapfrog turns the phase by 2 asin(w dt/2).
    """

    steps: int = 20_000
    turn: int = 200

    title: ClassVar[str] = "block that swings for very many steps"
    source: ClassVar[str] = "Hairer, Lubich & Wanner 2003, Geometric numerical integration by Stoermer's method"
    family: ClassVar[str] = "rest"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"steps": (20_000, 1_000_000), "turn": (100, 200)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"energy", "rest"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def applies(self, setup: Setup) -> str:
        """Refuse many steps with the other period, which would show the same."""
        dear = self.steps > LongRun.steps and self.turn != LongRun.turn
        return "runs with so many steps use one period of the spring only" if dear else super().applies(setup)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: thrown from rest of the spring; the weight presses all the time."""
        w = 2.0 * math.pi / (self.turn * STEP)
        mesh = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, HEIGHT], "cells": [1, 1]}
        block = {"material": "m", "element": setup.element, "mesh": mesh, "velocity": [w * SWING, 0.0]}
        law = {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}
        scene = {
            "name": "long-run", "time": {"end": self.steps * STEP, "step": STEP},
            "integrator": setup.integrator, "materials": {"m": law}, "bodies": {"block": block},
            "rigid": {"floor": {"line": [[100.0, 0.0], [-100.0, 0.0]], "segment": 10.0}},
            "contacts": [{"slave": "block.bottom", "master": "floor", "algorithm": setup.algorithm}],
            "effects": [
                {"use": "gravity", "acceleration": [0.0, -GRAVITY]},
                {"use": "spring", "on": "block", "stiffness": [MASS * w**2, 0.0]},
            ],
        }  # fmt: skip
        watch = series("time", "displacement.block.x", "push", every=max(1, self.steps // ROWS), most=ROWS + 10)
        return (Job("swings", scene, watch=(watch,), work=1.1 * self.steps),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The amplitude does not decay, and the phase equals the scheme's own."""
        why = "the spring pulls on every node as its mass does: the block swings as one, but for round-off"
        return (
            error("amplitude in the last tenth", 1e-6, why),
            error("phase in the end over a full turn", 1e-5, why),
            error("mean force of the floor over the weight, less one", 1e-3, "bounces of the start are half a row"),
            reported("turns"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """A fit of sine and cosine at the frequency of the scheme to the last tenth of the rows."""
        found = table(done["swings"])
        time, x = found["time"], found["displacement.block.x"]
        turn = 2.0 * math.asin(math.pi / self.turn) / STEP  # rad/s
        late = time > 0.9 * time[-1]
        waves = np.stack([np.sin(turn * time[late]), np.cos(turn * time[late])], axis=1)
        (sine, cosine), *_ = np.linalg.lstsq(waves, x[late], rcond=None)
        # x_n = A sin(n t), sin(t/2) = w dt/2, begins with v = A sin(t)/dt over the first step
        first = 1.0 / math.sqrt(1.0 - (math.pi / self.turn) ** 2)
        return {
            "amplitude in the last tenth": float(np.hypot(sine, cosine)) / SWING / first - 1.0,
            "phase in the end over a full turn": float(np.arctan2(cosine, sine)) / (2.0 * math.pi),
            "mean force of the floor over the weight, less one": float(np.mean(found["push"])) / (MASS * GRAVITY) - 1.0,
            "turns": float(turn * time[-1] / (2.0 * math.pi)),
        }
