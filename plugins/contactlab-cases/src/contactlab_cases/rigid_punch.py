"""A rigid flat punch on a block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup, Solution
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import only
from contactlab_cases.punches import block_under_punch
from contactlab_cases.statics import force_of, iterations, l2_error, ordered, static_job

MOST = 150  # iterations: mortars need three, and node-on-segment cycles at the corners of the punch


@dataclass(frozen=True)
class RigidPunch(Case):
    """A punch of half width 1 on a block 20 x 20, which is the slave; `cells` across the punch.

    The pressure under a given force does not depend on the material: `poisson`.
    """

    cells: int = 40
    poisson: float = 0.3

    title: ClassVar[str] = "rigid flat punch"
    source: ClassVar[str] = "Johnson 1985, Contact Mechanics, 2.8"
    family: ClassVar[str] = "complete contact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"cells": (40, 60, 80), "poisson": (0.0, 0.3)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"singular pressure"})
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2", "q1-fbar")
    swaps: ClassVar[bool] = False

    def applies(self, setup: Setup) -> str:
        """Allow other materials on one mesh only, which is enough to show that they do not matter."""
        other = self.poisson != RigidPunch.poisson and self.cells != RigidPunch.cells
        return "other materials are run on one mesh only" if other else super().applies(setup)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: the rigid punch pressed into the block."""
        mesh = block_under_punch(1.0, 10.0, 20.0, self._size(setup))
        line = [[-1.0, 1.0], [-1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
        job = static_job(
            "pressed", setup, {"m": {"young": 1000.0, "poisson": self.poisson}},
            {"block": {"material": "m", "mesh": mesh}}, {"slave": "block.top", "master": "punch"},
            rigid={"punch": {"line": line, "uy": {"ramp": "linear", "to": -1e-4}}},
            supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
        )  # fmt: skip
        return (replace(job, work=MOST),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """A single nodal force makes the multipliers next to it negative by 24 (P0) and 46 % (P1) of its own."""
        size = self._size(setup)
        most = 0.24 if setup.algorithm == "mortar-p0" else 0.46
        return (
            error(
                "L2 of the pressure over 0.9 a",
                min(0.005, 0.03 * size),
                "cells are graded to the edges: 0.3 to 0.45 % is left",
            ),
            error("pressure in the middle", min(0.005, 0.02 * size), "a block of ten half-widths is not a half-plane"),
            at_most("undershoot over the largest pressure", most, "caused by a single nodal force at its neighbours"),
            reported("iterations"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with p = P/(pi (a^2 - x^2)^(1/2)) of the measured force."""
        record = only(done)
        curve, force = record.curve(), force_of(record)
        x, p = ordered(curve.x, curve.pressure)

        def exact(at: Floats) -> Floats:
            return self._pressure(at, force)

        return {
            "L2 of the pressure over 0.9 a": l2_error(x, p, exact, 0.9),
            "pressure in the middle": float(np.interp(0.0, x, p)) / float(exact(np.zeros(1))[0]) - 1.0,
            "undershoot over the largest pressure": max(0.0, float(-p.min() / p.max())),
            "iterations": iterations(record),
        }

    def exact_pressure(self, setup: Setup, done: Mapping[str, Record]) -> Solution | None:
        """The same, over 0.9 a."""
        x = np.linspace(-0.9, 0.9, 4001)
        return Solution(x, self._pressure(x, force_of(only(done))), 0.0, "exact", window=(-0.9, 0.9))

    def _size(self, setup: Setup) -> float:
        return 40.0 / self.cells / setup.level

    @staticmethod
    def _pressure(at: Floats, force: float) -> Floats:
        """p = P/(pi (a^2 - x^2)^(1/2)) with a = 1 [MPa]."""
        return np.asarray(force / (np.pi * np.sqrt(np.maximum(1e-9, 1.0 - at**2))))
