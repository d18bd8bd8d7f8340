"""A plastic block between smooth rigid dies in plane strain: even flow, whose pressure follows the law of hardening."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error
from contactlab_cases.circles import only
from contactlab_cases.statics import static_job

WIDTH, HEIGHT, YOUNG, YIELD = 10.0, 15.0, 2e5, 200.0  # mm, of a quarter; MPa


@dataclass(frozen=True)
class Upsetting(Case):
    """`height` at the end over the initial height; `hardening` modulus [MPa]; `cells` across the quarter.

    The log strain e = ln(1/height) is but for an elastic part plastic, 2 e/sqrt(3), and the stress 2/sqrt(3) times that
    of the law.
    """

    height: float = 0.7
    hardening: float = 300.0
    cells: int = 4

    title: ClassVar[str] = "plastic block between smooth dies"
    source: ClassVar[str] = "Hill 1950, The Mathematical Theory of Plasticity: plane strain compression"
    family: ClassVar[str] = "large deformation"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"height": (0.5, 0.7), "hardening": (0.0, 300.0), "cells": (4, 8)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"large deformation", "plasticity"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1-fbar", "q1", "q2")
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """A quarter of the block; the die comes down."""
        n = self.cells * setup.level
        mesh = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, HEIGHT], "cells": [n, n]}
        law: dict[str, Any] = {
            "use": "linear-hardening", "young": YOUNG, "poisson": 0.3, "yield_stress": YIELD,
            "hardening": self.hardening,
        }  # fmt: skip
        down = (self.height - 1.0) * HEIGHT
        return (
            static_job(
                "upset", setup, {"steel": law}, {"block": {"material": "steel", "mesh": mesh}},
                {"slave": "block.top", "master": "die"}, steps=12,
                rigid={
                    "die": {"line": [[-WIDTH, HEIGHT], [4.0 * WIDTH, HEIGHT]], "uy": {"ramp": "linear", "to": down}}
                },
                supports=[{"on": "block.bottom", "uy": 0.0}, {"on": "block.left", "ux": 0.0}],
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bound pressures tightly: uniform flow is in the space of every element."""
        why = "elastic strains of 1e-3, and load steps of some per cent of strain"
        return [
            error("pressure of the die", 0.005, why),
            error("largest difference of the pressure from its mean", 1e-4, "the flow is even: iterations' tolerance"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the law of hardening."""
        pressure = only(done).curve().pressure
        mean = float(np.mean(pressure))
        strain = math.log(1.0 / self.height) - mean * (1.0 - 0.5 * 0.3) / YOUNG  # less the elastic part
        exact = 2.0 / math.sqrt(3.0) * (YIELD + self.hardening * 2.0 / math.sqrt(3.0) * strain)
        return {
            "pressure of the die": mean / exact - 1.0,
            "largest difference of the pressure from its mean": float(np.abs(pressure / mean - 1.0).max()),
        }
