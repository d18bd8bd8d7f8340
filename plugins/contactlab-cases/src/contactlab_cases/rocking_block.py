"""A slender block that rocks on its base without slip, and what speed an impact of the base leaves it.

A base of one cell touches at its corners alone, as Housner's rigid block: momentum about the new corner is kept, with
the moment of inertia that lumped masses have. Nodes between the corners stop at an impact, too, and push the block up:
the ratio of a wider mesh is larger, and reported. Vibrations are damped, so that the block is rigid between impacts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.dynamics import WORK
from contactlab_cases.series import series, table

GRAVITY, DENSITY, SOUND = 9810.0, 1e-9, 1e5  # mm/s2, t/mm3, mm/s
B, H = 2.5, 10.0  # mm, half-width and half-height
LEAN = math.atan(B / H)  # at which it would fall over
DAMPING = 2.0 * SOUND / H  # 1/s
END = 0.12  # s


@dataclass(frozen=True)
class RockingBlock(Case):
    """`start`: how far it leans at first, of the angle at which it falls over; `cells` along its base."""

    start: float = 0.5
    cells: int = 1

    title: ClassVar[str] = "block that rocks on its base"
    source: ClassVar[str] = "Housner 1963"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"start": (0.3, 0.5), "cells": (1, 2, 4)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "friction"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """One run from rest; it leans on its right corner."""
        n = self.cells * setup.level
        mesh = {"use": "rectangle", "x": [-2.0 * B, 0.0], "y": [0.0, 2.0 * H], "cells": [n, 4 * n]}
        block = {
            "material": "m", "element": setup.element, "mesh": mesh, "rotate": -math.degrees(self.start * LEAN),
        }  # fmt: skip
        law = {"use": "neo-hookean", "young": DENSITY * SOUND**2, "poisson": 0.0, "density": DENSITY}
        scene = {
            "name": "rocking-block", "time": {"end": END, "step": 0.3 * 2.0 * B / n / SOUND},
            "integrator": setup.integrator, "materials": {"m": law}, "bodies": {"block": block},
            "rigid": {"floor": {"line": [[40.0, 0.0], [-40.0, 0.0]], "segment": 80.0}},
            "contacts": [
                {
                    "slave": "block.bottom", "master": "floor", "algorithm": setup.algorithm,
                    "friction": {"use": "coulomb", "mu": 5.0},
                }
            ],
            "effects": [
                {"use": "gravity", "acceleration": [0.0, -GRAVITY]}, {"use": "vibration-damping", "rate": DAMPING},
            ],
        }  # fmt: skip
        watch = series("tilt.block", most=60000 * setup.level)
        return (Job("rocks", scene, watch=(watch,), work=WORK * self.cells * setup.level),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The speed that is left is exact where corners alone touch."""
        name = "speed left by an impact less that of lumped masses"
        why = "the corner gives by 1e-4 of the base, and leaves it in small bounces at first"
        told = error(name, 0.003, why) if self.cells * setup.level == 1 else reported(name)
        return (
            told,
            at_most("speed left by an impact", 1.0, "nothing drives it"),
            reported("speed left by an impact less Housner's 0.911765"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """From the heights of the centre before the fall and at the turn on the other side."""
        first = self.start * LEAN
        turn = float((table(done["rocks"])["tilt.block"] - first).max())
        fall, climb = (math.cos(LEAN - angle) - math.cos(LEAN) for angle in (first, turn))
        ratio, n = math.sqrt(max(0.0, climb) / fall), self.cells * setup.level
        inertia = B**2 * (1.0 / 3.0 + 2.0 / (3.0 * n**2)) + H**2 * (1.0 / 3.0 + 2.0 / (3.0 * (4 * n) ** 2))
        lumped = (inertia + H**2 - B**2) / (inertia + H**2 + B**2)
        return {
            "speed left by an impact less that of lumped masses": ratio - lumped,
            "speed left by an impact": ratio,
            "speed left by an impact less Housner's 0.911765": ratio - 1.0 + 1.5 * math.sin(LEAN) ** 2,
        }
