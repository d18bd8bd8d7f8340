"""Two beams, one clamped: the tip of the struck one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, invariant
from contactlab_cases.dynamics import WORK, strip
from contactlab_cases.series import table

PUBLISHED = {2e-4: -1.05e-4, 4e-4: -1.554199e-4, 6e-4: -5.541991e-5, 8e-4: 9.916018e-5, 1e-3: 2.991602e-4}
"""Displacement [m] of the struck end by time [s]; 5 % are allowed there."""


@dataclass(frozen=True)
class TwoBeams(Case):
    """The free one meets the clamped one at 1 m/s, in metres and kilograms; `cells` along each, `steps` in a ms."""

    cells: int = 50
    steps: int = 200

    title: ClassVar[str] = "two beams, one clamped (SDNL111)"
    source: ClassVar[str] = "Code_Aster V5.02.111"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"steps": (200, 400), "cells": (50, 100)}
    integrators: ClassVar[tuple[str, ...]] = ("implicit-dynamics",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: one beam hits the other."""
        cells, steps = self.cells * setup.level, self.steps * setup.level
        free = strip((0.0, 1.0), (0.0, 0.01), [cells, 1], velocity=[-1.0, 0.0], shift=[1e-5, 0.0])
        scene = {
            "name": "beams", "time": {"end": 1e-3, "step": 1e-3 / steps}, "integrator": setup.integrator,
            "materials": {"m": {"use": "linear-elastic", "young": 2e11, "poisson": 0.3, "density": 7800.0}},
            "bodies": {
                "free": free | {"element": setup.element},
                "clamped": strip((-1.0, 0.0), (0.0, 0.01), [cells, 1]) | {"element": setup.element},
            },
            "contacts": [
                {"slave": "free.left", "master": "clamped.right", "algorithm": setup.algorithm, "swap": setup.swap}
            ],
            "supports": [{"on": "free", "uy": 0.0}, {"on": "clamped", "uy": 0.0}, {"on": "clamped.left", "ux": 0.0}],
        }  # fmt: skip
        watch = {"use": "tip", "side": "master" if setup.swap else "slave"}  # the struck end belongs to the free beam
        return (Job("hit", scene, watch=(watch,), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Forces and displacements against published values, and the balance of energy."""
        why, codes = "the tolerance of the published test", ("early-contact",)
        found = [error(_at(time), 0.05, why, codes=codes) for time in PUBLISHED]
        return [*found, invariant("largest rise of energy in a step", 1e-9, "round-off; contact never adds energy")]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Take the tip of the free beam at five instants."""
        found = table(done["hit"], "tip")
        tips = {
            _at(t): float(np.interp(t, found["time"], found["tip"])) / exact - 1.0 for t, exact in PUBLISHED.items()
        }
        energy = found["energy"]
        return {**tips, "largest rise of energy in a step": float(np.diff(energy).max() / energy[0])}


def _at(time: float) -> str:
    return f"displacement at {1e3 * time:g} ms"
