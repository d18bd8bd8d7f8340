"""A rigid flat punch with rounded edges: a pressure with two peaks that no corner makes singular."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab_cases.circles import only
from contactlab_cases.indenters import MODULUS, errors, pressed, values

HALF = 0.02  # mm, of the contact, about


@dataclass(frozen=True)
class RoundedPunch(Case):
    """`flat` half-width over the contact's; `cells` in the latter. F(c) = c^2 (pi/2 - t - sin t cos t)/(2 R)
    with sin t = a/c, and F'(c) = c acos(a/c)/R."""

    flat: float = 0.6
    cells: int = 16

    title: ClassVar[str] = "rigid punch with rounded edges"
    source: ClassVar[str] = "Ciavarella, Hills & Monno 1998, Proc. I. Mech. E. C 212:319"
    family: ClassVar[str] = "edges"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"flat": (0.3, 0.6, 0.8), "cells": (16, 32)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    @property
    def radius(self) -> float:
        """Radius of the edges [mm]: slopes of 5e-4 where contact ends."""
        return (1.0 - self.flat) * HALF / 5e-4

    def total(self, c: Floats) -> Floats:
        """F(c) [mm]."""
        t = np.arcsin(np.minimum(1.0, self.flat * HALF / c))
        return np.asarray(0.5 * c**2 / self.radius * (0.5 * np.pi - t - np.sin(t) * np.cos(t)))

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run."""
        a = self.flat * HALF
        right = [[x, 0.5 * (x - a) ** 2 / self.radius] for x in np.linspace(a, 3.0 * HALF, 200).tolist()]
        line = [[-x, y] for x, y in right[::-1]] + right
        force = MODULUS * float(self.total(np.asarray(HALF)))
        return (pressed(setup, line, force, HALF, HALF / self.cells / setup.level),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bounds for 16 cells in the half-width, falling with them."""
        size = 16.0 / self.cells / setup.level
        return errors(0.05 * size, 0.06 * size, "a peak and a root at the edge within 3 to 6 of 16 cells")

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form of the measured force."""
        a, radius = self.flat * HALF, self.radius
        return values(only(done), self.total, lambda c: np.arccos(np.minimum(1.0, a / c)) / radius, a, 4.0 * HALF)
