"""A rigid flat punch that slides on a half plane: friction moves its pressure to one edge, by their exponents."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import only
from contactlab_cases.indenters import MODULUS, SIZE, YOUNG
from contactlab_cases.punches import block_under_punch
from contactlab_cases.statics import force_of, l2_error, ordered, static_job

HALF, CELLS, MEAN = 0.02, 20, 5e-5  # mm; cells in it at level 1; mean pressure over E*


def exponent(mu: float, poisson: float) -> float:
    """g of p ~ (a + x)^(g - 1/2) (a - x)^(-g - 1/2) under a punch that slides towards +x.

    The surface is pushed by q = mu p towards +x and stays flat:
    int p(s)/(x - s) ds = pi mu (1 - 2 nu)/(2 (1 - nu)) p(x).
    """
    return -math.atan(mu * (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson))) / math.pi


def sliding_pressure(x: Floats, force: float, half: float, g: float) -> Floats:
    """p(x) [MPa] of a force per length [N/mm]."""
    x = np.clip(x, -half * (1.0 - 1e-9), half * (1.0 - 1e-9))
    root = np.pi * np.sqrt(half**2 - x**2)
    return np.asarray(force * math.cos(math.pi * g) / root * ((half + x) / (half - x)) ** g)


@dataclass(frozen=True)
class SlidingPunch(Case):
    """`mu` of Coulomb's law; `poisson` of the half plane: at 0.5 friction does not change the pressure."""

    mu: float = 0.6
    poisson: float = 0.2

    title: ClassVar[str] = "rigid flat punch that slides"
    source: ClassVar[str] = "Johnson 1985, Contact Mechanics, 2.8; Muskhelishvili 1949"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.2, 0.6, 1.0), "poisson": (0.0, 0.2, 0.4)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"singular pressure", "friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Pressed until t = 1, drawn to the right until 2, ten times as far as the surface can follow."""
        mesh = block_under_punch(HALF, 8.0 * SIZE, 4.0 * SIZE, 1.0 / setup.level)  # wide: a narrow block would lean
        force = 2.0 * HALF * MEAN * MODULUS
        up = 2.0 * force / (np.pi * MODULUS) * (0.5 + math.log(8.0 * SIZE / HALF))
        path = float(10.0 * self.mu * up)
        return (
            static_job(
                "drawn", setup, {"plane": {"young": YOUNG, "poisson": self.poisson}},
                {"block": {"material": "plane", "mesh": mesh}},
                {"slave": "block.top", "master": "punch", "friction": {"use": "coulomb", "mu": self.mu}},
                rigid={
                    "punch": {
                        "line": [[-HALF - path, 0.0], [HALF - path, 0.0]],  # at the end its edges are on nodes
                        "ux": {"ramp": "linear", "to": path, "begin": 1.0, "duration": 1.0},
                    }
                },
                supports=[
                    {"on": "block.bottom", "ux": 0.0, "uy": {"ramp": "linear", "to": float(up), "duration": 1.0}}
                ],
                time={"end": 2.0}, steps=2,
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Return measures over the middle eight tenths; the edges are singular."""
        why = "cells are graded to the edges: mortars are off by 0.1 to 0.3 %"
        return [
            error("L2 of the pressure over 0.8 of the contact", 0.005, why),
            error("pressure at 0.5 a over that at -0.5 a", 0.005, why),
            error("shear over mu p, largest difference", 1e-6, "all of it slides: Newton's tolerance"),
            at_most("undershoot over the largest pressure", 0.46, "caused by a single nodal force at its neighbours"),
            reported("sideways force over mu P"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the pressure of the measured force."""
        record = only(done)
        curve, force, g = record.curve(), force_of(record), exponent(self.mu, self.poisson)
        x, p, q = ordered(curve.x, curve.pressure, curve.shear)
        middle = 0.5 * (float(x[p > 0.0].min()) + float(x[p > 0.0].max()))

        def exact(at: Floats) -> Floats:
            return sliding_pressure(at, force, HALF, g)

        sides = [float(np.interp(middle + side * 0.5 * HALF, x, p)) for side in (1.0, -1.0)]
        wanted = exact(0.5 * HALF * np.array([1.0, -1.0]))
        inside = np.abs(x - middle) < 0.9 * HALF
        return {
            "L2 of the pressure over 0.8 of the contact": l2_error(x - middle, p, exact, 0.8 * HALF),
            "pressure at 0.5 a over that at -0.5 a": sides[0] / sides[1] / float(wanted[0] / wanted[1]) - 1.0,
            "shear over mu p, largest difference": float(np.abs(np.abs(q[inside] / p[inside]) / self.mu - 1.0).max()),
            "undershoot over the largest pressure": max(0.0, float(-p.min() / p.max())),
            "sideways force over mu P": abs(float(record.reaction("block.bottom")[0])) / self.mu / force,
        }
