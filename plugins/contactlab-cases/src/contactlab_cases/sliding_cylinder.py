"""A cylinder that slides on a block of its own material: Hertz's pressure, and mu times it everywhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import disc_on_block, hertz, only
from contactlab_cases.mindlin import centred
from contactlab_cases.statics import l2_error, plane_strain

RADIUS, YOUNG = 10.0, 70000.0
DEPTH, HALF_WIDTH = 8e-4, 0.0175  # radii


@dataclass(frozen=True)
class SlidingCylinder(Case):
    """`mu`; `segments` in a half-width. Like materials: shear does not change the pressure."""

    mu: float = 0.3
    segments: float = 8.0

    title: ClassVar[str] = "cylinder that slides, like materials"
    source: ClassVar[str] = "Johnson 1985, Contact Mechanics, 7.1"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.1, 0.3, 0.6), "segments": (8.0, 16.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "curved contact"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Pressed until t = 1, drawn sideways until t = 2, far enough that all of it slides."""
        push = {
            "on": "disc.top",
            "ux": {"ramp": "linear", "to": 8e-4 * self.mu / 0.3 * RADIUS, "begin": 1.0, "duration": 1.0},
            "uy": {"ramp": "linear", "to": -DEPTH * RADIUS, "duration": 1.0},
        }
        h = HALF_WIDTH / self.segments / setup.level
        contact = {"friction": {"use": "coulomb", "mu": self.mu}}
        return (
            disc_on_block(
                setup, RADIUS, (YOUNG, YOUNG), DEPTH, h, growth=1.06, push=push, contact=contact, time={"end": 2.0},
                steps=2,
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bounds of Hertz's cylinder."""
        size = 8.0 / self.segments / setup.level
        why = "exact nodal values are off by 4 % at 8 segments: a root at the edge that no linear interpolant follows"
        return (
            error("L2 of the pressure", 0.06 * size, why),
            error("largest pressure", 0.03 * size, why),
            error("shear over mu p, largest difference", 1e-6, "all of it slides: Newton's tolerance"),
            error("sideways force over mu P, less one", 0.02, "the disc rolls a little: its base leans by a hundredth"),
            reported("share of closed nodes that slip"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form of the measured force."""
        record = only(done)
        curve = record.curve()
        fx, fy = record.reaction("block.bottom")
        a, p0, exact = hertz(float(fy), RADIUS, plane_strain(YOUNG) / 2.0)
        closed = curve.pressure > 0.05 * p0
        return {
            "L2 of the pressure": l2_error(centred(curve), curve.pressure, exact, 2.0 * a),
            "largest pressure": float(curve.pressure.max()) / p0 - 1.0,
            "shear over mu p, largest difference": float(
                np.abs(np.abs(curve.shear) / np.maximum(1e-300, curve.pressure) / self.mu - 1.0)[closed].max()
            ),
            "sideways force over mu P, less one": abs(float(fx)) / (self.mu * float(fy)) - 1.0,
            "share of closed nodes that slip": float(np.mean(np.asarray(curve.state)[closed] == 2)),
        }
