"""A slender block that rocks on its base without slip, and its speed after an impact of the base.

A base of one cell touches at its corners alone, as Housner's rigid block: momentum about the new corner is kept, with
the moment of inertia that lumped masses have. Nodes between the corners stop at an impact, too, and push the block up:
the ratio of a finer mesh is larger, as for an elastic block, and reported with the change from half as many
cells. It changes by less and less, but slowly: a corner on a floor gives the more the finer its cells are. Vibrations
are damped, so that the block is rigid between impacts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.dynamics import WORK, energy_under_weight, rise
from contactlab_cases.series import series, table

GRAVITY, DENSITY, SOUND = 9810.0, 1e-9, 1e5  # mm/s2, t/mm3, mm/s
B, H = 2.5, 10.0  # mm, half-width and half-height
LEAN = math.atan(B / H)  # at which it would fall over
DAMPING = 2.0 * SOUND / H  # 1/s
END = 0.12  # s
FINE = 8  # cells, from which on the change from half as many is judged
HALVED = "change of it from half as many cells"
RISE = "largest rise of the energy in a step over that of the fall"


@dataclass(frozen=True)
class RockingBlock(Case):
    """`start`: how far it leans at first, of the angle at which it falls over; `cells` along its base."""

    start: float = 0.5
    cells: int = 1

    title: ClassVar[str] = "block that rocks on its base"
    source: ClassVar[str] = "Housner 1963"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"start": (0.3, 0.5), "cells": (1, 4, FINE)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "friction"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def applies(self, setup: Setup) -> str:
        """The finest mesh is looked at from one height."""
        if self.cells >= FINE and self.start != RockingBlock.start:
            return "the change with the mesh is studied for one height only"
        return super().applies(setup)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan a run from rest, leaning on the right corner; on fine meshes another on half as many cells."""
        n = self.cells * setup.level
        return (self._job("rocks", n, setup), *((self._job("coarser", n // 2, setup),) if n >= FINE else ()))

    def _job(self, name: str, n: int, setup: Setup) -> Job:
        mesh = {"use": "rectangle", "x": [-2.0 * B, 0.0], "y": [0.0, 2.0 * H], "cells": [n, 4 * n]}
        block = {
            "material": "m", "element": setup.element, "mesh": mesh, "rotate": -math.degrees(self.start * LEAN),
        }  # fmt: skip
        law = {"use": "neo-hookean", "young": DENSITY * SOUND**2, "poisson": 0.0, "density": DENSITY}
        scene = {
            "name": "rocking-block", "time": {"end": END, "step": 0.45 * 2.0 * B / n / SOUND},
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
        names = ("tilt.block", "kinetic", "work.internal", "position.block.y", "work.contact")
        return Job(name, scene, watch=(series(*names, most=8000 * n),), work=WORK * n)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The remaining speed is exact if only corners touch."""
        name = "speed left by an impact less that of lumped masses"
        why = "the corner gives by 1e-4 of the base, and leaves it in small bounces at first"
        n = self.cells * setup.level
        told = error(name, 0.003, why) if n == 1 else reported(name)
        finer = (error(HALVED, 0.01, "1.0 % from two cells to four, 0.7 % from there to eight"),) if n >= FINE else ()
        return (
            told,
            at_most("speed left by an impact", 1.0, "nothing drives it"),
            *finer,
            at_most(RISE, 1e-9, "contact, friction and damping never add energy: round-off"),
            reported("largest gift of contact in a step over it"),
            reported("speed left by an impact less Housner's 0.911765"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Find speeds from the heights of the centre; energies over the energy of the fall."""
        found, n = table(done["rocks"]), self.cells * setup.level
        ratio = self._ratio(found)
        inertia = B**2 * (1.0 / 3.0 + 2.0 / (3.0 * n**2)) + H**2 * (1.0 / 3.0 + 2.0 / (3.0 * (4 * n) ** 2))
        lumped = (inertia + H**2 - B**2) / (inertia + H**2 + B**2)
        weight = DENSITY * GRAVITY * 4.0 * B * H
        fall = weight * math.hypot(B, H) * self._height(self.start * LEAN)
        halved = {HALVED: ratio / self._ratio(table(done["coarser"])) - 1.0} if "coarser" in done else {}
        return halved | {
            "speed left by an impact less that of lumped masses": ratio - lumped,
            "speed left by an impact": ratio,
            RISE: rise(energy_under_weight(found, "block", weight)) / fall,
            "largest gift of contact in a step over it": rise(found["work.contact"]) / fall,
            "speed left by an impact less Housner's 0.911765": ratio - 1.0 + 1.5 * math.sin(LEAN) ** 2,
        }

    def _ratio(self, found: Mapping[str, Floats]) -> float:
        """Ratio of speeds, from heights of the centre before the fall and at the turn on the other side."""
        first = self.start * LEAN
        turn = float((found["tilt.block"] - first).max())
        return math.sqrt(max(0.0, self._height(turn)) / self._height(first))

    @staticmethod
    def _height(angle: float) -> float:
        """Height of the centre over its place with the base on the floor, in half-diagonals."""
        return math.cos(LEAN - angle) - math.cos(LEAN)
