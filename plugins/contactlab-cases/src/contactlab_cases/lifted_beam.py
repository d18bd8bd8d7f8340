"""A heavy beam on a rigid floor, lifted at one end: how far it comes off the floor, and the force that it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import ordered, static_job

HEIGHT, YOUNG, WEIGHT = 1.0, 1000.0, 1e-5  # mm, MPa, N/mm; nu = 0
SPAN = 30.0  # mm, of what is lifted at the default height


@dataclass(frozen=True)
class LiftedBeam(Case):
    """`lift` of the end over the lift of a span of 30; `cells` in 30.

    E I v'''' = -w, v = v' = v'' = 0 where it leaves the floor and M = 0 at the end: v(L) = w L^4/(24 E I), and the
    force is w L/2. As much presses on the floor in one point where the beam leaves it.
    """

    lift: float = 1.0
    cells: int = 24

    title: ClassVar[str] = "heavy beam lifted at one end"
    source: ClassVar[str] = "Timoshenko, Strength of Materials II, 1930: a beam on a rigid foundation"
    family: ClassVar[str] = "beams"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"lift": (0.2, 1.0), "cells": (24, 48)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "quadratic edges"})
    proves: ClassVar[frozenset[str]] = frozenset({"partial contact"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q2", "q2-lagrange")
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: the weight is a dead load of the top."""
        n = 2 * self.cells * setup.level
        mesh = {"use": "rectangle", "x": [-SPAN, SPAN], "y": [0.0, HEIGHT], "cells": [n, 1]}
        return (
            static_job(
                "lifted", setup, {"m": {"young": YOUNG, "poisson": 0.0}}, {"beam": {"material": "m", "mesh": mesh}},
                {"slave": "beam.bottom", "master": "floor"}, steps=2,
                rigid={"floor": {"line": [[2.0 * SPAN, 0.0], [-2.0 * SPAN, 0.0]]}},
                supports=[
                    {"on": "beam.left", "ux": 0.0},
                    {"on": "beam.right", "uy": {"ramp": "linear", "to": self.lift * self._height(SPAN)}},
                ],
                loads=[{"on": "beam.top", "ty": -WEIGHT, "follower": False}],
            ),
        )  # fmt: skip

    @staticmethod
    def _height(span: float) -> float:
        return WEIGHT * span**4 / (2.0 * YOUNG * HEIGHT**3)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The force is half of the lifted weight."""
        cell = 1.0 / self.cells / setup.level / self.lift**0.25
        return [
            error("force that lifts", 0.01 + 0.3 * cell, "shear, 1/900 of the deflection, and the place by a cell"),
            error("length that is lifted", 0.01 + cell, "nodes show where it leaves the floor to a cell"),
            reported("force in one point over that which lifts"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the beam."""
        record = only(done)
        span = SPAN * self.lift**0.25
        curve = record.curve()
        x, force = ordered(curve.x, curve.nodal_pressure)
        last = float(x[np.flatnonzero(force > 1e-3 * WEIGHT)].max())
        total = 2.0 * SPAN * WEIGHT
        lifting = float(record.reaction("beam.right")[1])
        floor = total - lifting
        even = WEIGHT * (2.0 * SPAN - span)
        return {
            "force that lifts": lifting / (0.5 * WEIGHT * span) - 1.0,
            "length that is lifted": (SPAN - last) / span - 1.0,
            "force in one point over that which lifts": (floor - even) / lifting,
        }
