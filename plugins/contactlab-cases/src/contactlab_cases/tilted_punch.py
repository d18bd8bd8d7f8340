"""A rigid flat punch that leans: its pressure is singular at both edges, or one of them lifts off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import only
from contactlab_cases.indenters import MODULUS, SIZE, pressed
from contactlab_cases.punches import block_under_punch
from contactlab_cases.statics import force_of, l2_error, ordered

HALF, CELLS, SLOPE = 0.02, 20, 5e-4  # mm, cells in it at level 1


@dataclass(frozen=True)
class TiltedPunch(Case):
    """`load` over that at which the high edge lifts off, E* slope pi a/2: the centre of pressure is then at a/2.

    With less, contact has the length 2 l = 4 P/(pi E* slope) and p = P/(pi l) ((l + z)/(l - z))^(1/2) from its middle;
    with more p = P/(pi (a^2 - x^2)^(1/2)) (1 + 2 e x/a^2), e = pi a^2 E* slope/(4 P).
    """

    load: float = 2.0
    slope: float = SLOPE

    title: ClassVar[str] = "rigid flat punch that leans"
    source: ClassVar[str] = "Johnson 1985, Contact Mechanics, 2.8; Muskhelishvili 1949"
    family: ClassVar[str] = "complete contact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"load": (0.5, 0.9, 1.1, 2.0, 4.0), "slope": (1e-4, SLOPE)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"singular pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: the punch is low on its right."""
        a, high = HALF, 2.0 * HALF * self.slope
        line = [[-a, high], [a, 0.0]]
        force = self.load * 0.5 * np.pi * MODULUS * self.slope * a
        half = a * min(1.0, self.load)
        mesh = block_under_punch(half, 2.0 * SIZE, 4.0 * SIZE, 1.0 / setup.level, a - half)
        return (pressed(setup, line, force, a, HALF / CELLS / setup.level, mesh=mesh),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Return measures over the middle eight tenths of the contact; the edges are singular."""
        why = "cells are graded to the ends of contact: mortars are off by 0.2 to 0.4 %"
        return [
            error("L2 of the pressure over 0.8 of the contact", 0.005, why),
            error("where the high edge lifts off in cells", 1.0, "nodes show it to a cell")
            if self.load < 1.0
            else reported("where the high edge lifts off in cells"),
            at_most("undershoot over the largest pressure", 0.46, "caused by a single nodal force at its neighbours"),
            reported("load over that of lift-off"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the pressure of the measured force."""
        record, a = only(done), HALF
        force, curve = force_of(record), record.curve()
        x, p = ordered(curve.x, curve.pressure)
        lifting = 0.5 * np.pi * MODULUS * self.slope * a
        half = min(a, a * force / lifting)
        middle, e = a - half, (0.5 * a * lifting / force if half == a else 0.5 * half)

        def exact(z: Floats) -> Floats:
            root = np.sqrt(np.maximum(1e-12, half**2 - z**2))
            return np.asarray(force / (np.pi * root) * (1.0 + 2.0 * e * z / half**2))

        closed = x[ordered(curve.x, curve.nodal_pressure)[1] > 0.0]
        return {
            "L2 of the pressure over 0.8 of the contact": l2_error(x - middle, p, exact, 0.8 * half),
            "where the high edge lifts off in cells": (float(closed.min()) - middle + half) / a * CELLS * setup.level,
            "undershoot over the largest pressure": max(0.0, float(-p.min() / p.max())),
            "load over that of lift-off": force / lifting,
        }
