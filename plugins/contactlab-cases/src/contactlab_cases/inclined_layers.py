"""Two layers with an inclined interface under an even stress: they stick, or slip at Coulomb's ratio of stresses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import HELD_BY_FRICTION, static_job

YOUNG, SIDE = 1000.0, 1e-3  # MPa; pressure on both sides
MOST = 1e-2  # MPa: the stress along y that both layers would carry as one, without slip


@dataclass(frozen=True)
class InclinedLayers(Case):
    """`angle` of the interface [degrees], `mu`, and `ratio` of the upper layer's cells to the lower one's.

    Stresses are even: p along y, SIDE along x. On the interface s = p cos^2 + SIDE sin^2 and t = (p - SIDE) sin cos;
    t = mu s at p = SIDE (sin cos + mu sin^2)/(sin cos - mu cos^2), where it slips. With tan(angle) < mu it never does.
    """

    angle: float = 30.0
    mu: float = 0.3
    ratio: float = 1.4

    title: ClassVar[str] = "two layers with an inclined interface"
    source: ClassVar[str] = "Coulomb; Mohr 1882: stresses on an inclined plane"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"angle": (20.0, 30.0), "mu": (0.2, 0.3, 0.8), "ratio": (1.0, 1.4)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "stick and slip"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2-lagrange", "q1-fbar")

    @property
    def slips(self) -> bool:
        """Return whether the interface slips before the stress without slip is reached."""
        return self._limit() < MOST

    def _limit(self) -> float:
        s, c = math.sin(math.radians(self.angle)), math.cos(math.radians(self.angle))
        hold = s * c - self.mu * c * c
        return SIDE * (s * c + self.mu * s * s) / hold if hold > 0.0 else math.inf

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The top comes down; the upper layer is free sideways, the lower one but for its left side."""
        rise = 0.5 * math.tan(math.radians(self.angle))
        n = 5 * setup.level
        corners = {
            "lower": [[-0.5, -1.0], [0.5, -1.0], [0.5, rise], [-0.5, -rise]],
            "upper": [[-0.5, -rise], [0.5, rise], [0.5, 1.0], [-0.5, 1.0]],
        }
        cells = {"lower": [n, n], "upper": [round(self.ratio * n), n]}
        bodies = {
            k: {"material": "m", "mesh": {"use": "quad-block", "corners": corners[k], "cells": cells[k]}} for k in cells
        }
        pressed = ("lower.right", "upper.left", "upper.right")
        down = {"ramp": "linear", "to": -2.0 * MOST / YOUNG}
        loads = [{"on": side, "pressure": {"ramp": "linear", "to": SIDE}, "follower": False} for side in pressed]
        return (
            static_job(
                "pressed", setup, {"m": {"young": YOUNG, "poisson": 0.0}}, bodies,
                {
                    "slave": "upper.bottom", "master": "lower.top", "friction": {"use": "coulomb", "mu": self.mu},
                    "enforcement": HELD_BY_FRICTION,
                },
                steps=8, loads=loads,
                supports=[
                    {"on": "lower.bottom", "uy": 0.0}, {"on": "lower.left", "ux": 0.0}, {"on": "upper.top", "uy": down}
                ],
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Uniform stresses; strains and slips of 2e-5 leave as much."""
        why, told = "stresses are even; slips of 1e-5 uncover as much of a segment", ("creep", "patch-test")
        return [
            error("stress along y", 1e-3, why, codes=told),
            error("pressure on the interface, largest difference", 5e-3, why, codes=told),
            error("shear on the interface, largest difference", 5e-3, why, codes=told),
            reported("share of nodes that slip"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with Mohr's circle."""
        record = only(done)
        stress = min(self._limit(), MOST)
        s, c = math.sin(math.radians(self.angle)), math.cos(math.radians(self.angle))
        pressure, shear = stress * c * c + SIDE * s * s, (stress - SIDE) * s * c
        curve = record.curve()
        return {
            "stress along y": -float(record.reaction("upper.top")[1]) / stress - 1.0,
            "pressure on the interface, largest difference": float(np.abs(curve.pressure / pressure - 1.0).max()),
            "shear on the interface, largest difference": float(np.abs(np.abs(curve.shear) / shear - 1.0).max()),
            "share of nodes that slip": float(np.mean(np.asarray(curve.state) == 2)),
        }
