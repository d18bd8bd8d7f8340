"""A rigid profile h = x^4/A^3 on a half plane: flat at its apex, the pressure is largest away from the middle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab_cases.circles import only
from contactlab_cases.indenters import MODULUS, errors, pressed, values

HALF = 0.02  # mm, of the contact, about
SLOPE = 5e-4  # where contact ends


@dataclass(frozen=True)
class FourthPower(Case):
    """`cells` in the half-width; `offset` of the apex from a node, in cells. F(c) = 3 pi c^4/(4 A^3)."""

    cells: int = 10
    offset: float = 0.0

    title: ClassVar[str] = "rigid profile x^4 on a half plane"
    source: ClassVar[str] = "Steuermann 1939; Johnson 1985, Contact Mechanics, 5.3"
    family: ClassVar[str] = "edges"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"cells": (10, 20, 40), "offset": (0.0, 0.5)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run."""
        h, cube = HALF / self.cells / setup.level, 4.0 * HALF**3 / SLOPE
        x = np.linspace(-3.0 * HALF, 3.0 * HALF, 401)
        line = np.stack([x + self.offset * h, x**4 / cube], axis=1).tolist()
        return (pressed(setup, line, 0.75 * np.pi * MODULUS * HALF**4 / cube, HALF, h),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bounds for 10 cells in the half-width, falling with them."""
        size = 10.0 / self.cells / setup.level
        return errors(
            0.04 * size, 0.08 * size, "a root at the edge that 10 cells follow to 3 to 6 %, and P1 overshoots at it"
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form of the measured force, from the apex."""
        record, cube = only(done), 4.0 * HALF**3 / SLOPE
        curve = record.curve()
        curve.x[:] = curve.x - self.offset * HALF / self.cells / setup.level
        return values(
            record, lambda c: 0.75 * np.pi * c**4 / cube, lambda c: 3.0 * np.pi * c**2 / cube, 0.0, 4.0 * HALF
        )
