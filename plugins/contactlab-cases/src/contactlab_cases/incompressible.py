"""A rigid cylinder on a nearly incompressible block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, reported
from contactlab_cases.circles import SOURCE, hertz_measures, hertz_values, only
from contactlab_cases.statics import graded_count, ordered, plane_strain, static_job

RADIUS, YOUNG = 8.0, 10.0


@dataclass(frozen=True)
class Incompressible(Case):
    """R = 8 pressed 0.15 into a block 40 x 20, E = 10; or less deep: `depth` [mm]."""

    poisson: float = 0.499
    depth: float = 0.15

    title: ClassVar[str] = "rigid cylinder on a nearly incompressible block"
    source: ClassVar[str] = SOURCE
    family: ClassVar[str] = "hertz"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"poisson": (0.3, 0.49, 0.499), "depth": (0.1, 0.15)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"curved contact", "locking"})
    elements: ClassVar[tuple[str, ...]] = ("q1-fbar", "q2-lagrange", "q1")
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: the nearly incompressible bodies pressed together."""
        h = 0.1 / setup.level
        rows = graded_count(20.0, h, 1.15)
        mesh = {
            "use": "rectangle", "x": [-20.0, -1.5, 1.5, 20.0], "y": [-20.0, 0.0],
            "cells": [[14, round(3.0 / h), 14], rows], "grading": [[0.02, 1.0, 50.0], 1.15 ** -(rows - 1)],
        }  # fmt: skip
        arc = {"centre": [0.0, RADIUS], "radius": RADIUS, "angles": [250.0, 290.0]}
        material = {"m": {"young": YOUNG, "poisson": self.poisson}}
        return (
            static_job(
                "pressed", setup, material, {"block": {"material": "m", "mesh": mesh}},
                {"slave": "block.top", "master": "cylinder"},
                rigid={"cylinder": {"arc": arc, "segment": h, "uy": {"ramp": "linear", "to": -self.depth}}},
                supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Judge elements that do not lock; for others report the numbers only, as a warning reports locking."""
        judged = setup.element == "q1-fbar" or self.poisson < 0.4
        inf = float("inf")
        peak = 0.05 if judged else inf
        why = "a strain of 1/10 under a circle, and 11 segments in a half-width"
        smooth = at_most("oscillation", 0.2, "second differences of a smooth pressure are 8/n^2, and more at its edges")
        return [*hertz_measures(peak, inf, inf, why), smooth if judged else reported("oscillation")]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare the pressure with Hertz's at the measured force."""
        curve = only(done).curve()
        p = ordered(curve.x, curve.pressure)[1]
        values = hertz_values(only(done), RADIUS, plane_strain(YOUNG, self.poisson))
        return {**values, "oscillation": float(np.abs(np.diff(p, 2)).sum() / np.abs(p).sum())}
