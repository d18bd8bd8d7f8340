"""A rigid wave on an elastic half plane: partial contact at a small pressure, contact everywhere at a large one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup, Solution
from contactlab.api.case import error, reported
from contactlab_cases.circles import only, peak_error
from contactlab_cases.statics import ordered, plane_strain, static_job

LENGTH = 1.0  # mm, of the wave
YOUNG = 70000.0
CELLS = 40  # along half a wave, at level 1
DEPTH = 2.0  # wave lengths: a pressure of this period has died away by exp(-4 pi)
POINTS = 400  # of the rigid line on half a wave: its facets are 2e-6 of the amplitude deep


@dataclass(frozen=True)
class Westergaard(Case):
    """Pressure under a rigid wave.

    load       mean pressure over the full contact pressure, about: it is reached through a displacement, and measured
    amplitude  of the wave [mm]: strains of 1e-4, or of 1e-6, under which gaps are small against segments
    """

    load: float = 0.5
    amplitude: float = 2e-5

    title: ClassVar[str] = "a rigid wave on a half plane"
    source: ClassVar[str] = "Westergaard 1939; Johnson 1985, Contact Mechanics, 13.2"
    family: ClassVar[str] = "edges"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "load": (0.25, 0.5, 0.75, 1.5),
        "amplitude": (2e-7, 2e-5),
    }
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: the wave comes down, or the half plane's foot comes up, by what the mean pressure needs."""
        half, n = 0.5 * LENGTH, CELLS * setup.level
        x = np.linspace(-0.1 * half, 1.1 * half, POINTS + 1)
        line = [[float(v), float(self.amplitude * (1.0 - np.cos(2.0 * np.pi * v / LENGTH)))] for v in x]
        modulus = plane_strain(YOUNG)
        stiff = YOUNG * 0.7 / (1.3 * 0.4)  # of a layer that cannot widen [MPa]
        down = self.load * self._full(modulus) * DEPTH * LENGTH / stiff + self.amplitude * min(1.0, self.load)
        body = {
            "material": "soft",
            "mesh": {
                "use": "rectangle", "x": [0.0, half], "y": [-DEPTH * LENGTH, 0.0], "cells": [n, n],
                "grading": [1.0, 1.0 / 12.0],
            },
        }  # fmt: skip
        return [static_job(
            "pressed", setup, {"soft": {"young": YOUNG, "poisson": 0.3}}, {"layer": body},
            {"slave": "layer.top", "master": "wave"},
            rigid={"wave": {"line": line}},
            supports=[
                {"on": "layer.left", "ux": 0.0}, {"on": "layer.right", "ux": 0.0},
                {"on": "layer.bottom", "uy": down},
            ],
        )]  # fmt: skip

    def _full(self, modulus: float) -> float:
        """p* [MPa], the mean pressure from which on contact is everywhere."""
        return np.pi * modulus * self.amplitude / LENGTH

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Errors of the pressure."""
        return [
            error("largest pressure", 0.02, "cells of 1/80 of the wave"),
            error("L2 of the pressure", 0.05, "the root at the edge of contact is resolved to half a cell", order=1.0),
            reported("mean pressure over that of full contact"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form at the measured mean pressure."""
        record = only(done)
        full = self._full(plane_strain(YOUNG))
        mean = float(record.reaction("layer.bottom")[1]) / (0.5 * LENGTH)
        curve = record.curve()
        x, pressure = ordered(curve.x, curve.pressure)
        at = np.linspace(0.0, 0.5 * LENGTH, 4001)
        exact, found = self.pressure(at, mean, full), np.interp(at, x, pressure)
        return {
            "largest pressure": peak_error(record, at, lambda x: self.pressure(x, mean, full)),
            "L2 of the pressure": float(np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2))),
            "mean pressure over that of full contact": mean / full,
        }

    def exact_pressure(self, setup: Setup, done: Mapping[str, Record]) -> Solution | None:
        """The closed form at the mean pressure that was measured."""
        half = 0.5 * LENGTH
        mean = float(only(done).reaction("layer.bottom")[1]) / half
        x = half * np.linspace(0.0, 1.0, 8001)
        return Solution(x, self.pressure(x, mean, self._full(plane_strain(YOUNG))), 0.0, "exact", window=(0.0, half))

    @staticmethod
    def pressure(x: Floats, mean: float, full: float) -> Floats:
        """p(x) [MPa] at a mean pressure, x from a crest; `full` is the mean from which on contact is everywhere."""
        if mean >= full:
            return np.asarray(mean + full * np.cos(2.0 * np.pi * x / LENGTH))
        s2 = mean / full
        root = np.sqrt(np.maximum(0.0, s2 - np.sin(np.pi * x / LENGTH) ** 2))
        return np.asarray(2.0 * mean * np.cos(np.pi * x / LENGTH) / s2 * root)
