"""A table that rises and stops tosses a block: it leaves, flies and lands as a point does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import brentq

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error
from contactlab_cases.dynamics import WORK
from contactlab_cases.series import series, table

GRAVITY, DENSITY, SIZE = 9810.0, 1e-9, 2.0  # mm/s2, t/mm3, mm
LIFT, RESTS = 20.0, 0.01  # mm; s, in which the weight comes and vibrations go before the table rises


@dataclass(frozen=True)
class TossedBlock(Case):
    """The table rises by 20 mm as 3 s^2 - 2 s^3, s = t/T; the block leaves it where it brakes harder than gravity.

    jerk   6 H/(T^2 g), the largest braking over gravity
    young  modulus of the block [MPa]: what it vibrates with is small
    """

    jerk: float = 3.0
    young: float = 2.0

    title: ClassVar[str] = "block tossed by a table"
    source: ClassVar[str] = "Newton: free flight"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"jerk": (1.5, 3.0, 6.0), "young": (2.0, 20.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "release"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def flight(self) -> tuple[float, float, float, float]:
        """Time of the rise, of leaving, of landing [s] since it began, and height of flight over its end [mm]."""
        rise = float(np.sqrt(6.0 * LIFT / (self.jerk * GRAVITY)))
        s = 0.5 * (1.0 + 1.0 / self.jerk)  # 6 H/T^2 (2 s - 1) = g
        leaves, height, speed = s * rise, LIFT * s**2 * (3.0 - 2.0 * s), 6.0 * LIFT * s * (1.0 - s) / rise

        def above(t: float) -> float:
            q = min(1.0, t / rise)
            return height + speed * (t - leaves) - 0.5 * GRAVITY * (t - leaves) ** 2 - LIFT * q**2 * (3.0 - 2.0 * q)

        top = leaves + speed / GRAVITY
        last = leaves + 2.0 * (speed + np.sqrt(2.0 * GRAVITY * LIFT)) / GRAVITY
        lands = float(brentq(above, top, last))
        return rise, leaves, lands, height + 0.5 * speed**2 / GRAVITY - LIFT

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The block rests first; what it vibrates with is damped until the table rises."""
        rise, _, lands, _ = self.flight()
        n = 2 * setup.level
        mesh = {"use": "rectangle", "x": [0.0, SIZE], "y": [0.0, SIZE], "cells": [n, n]}
        law = {"use": "linear-elastic", "young": self.young, "poisson": 0.0, "density": DENSITY}
        up = {"ramp": "smooth", "to": LIFT, "begin": RESTS, "duration": rise}
        scene = {
            "name": "tossed-block", "time": {"end": RESTS + lands + 0.1 * rise}, "integrator": setup.integrator,
            "materials": {"m": law},
            "bodies": {"block": {"material": "m", "element": setup.element, "mesh": mesh}},
            "rigid": {"table": {"line": [[3.0 * SIZE, 0.0], [-2.0 * SIZE, 0.0]], "uy": up}},
            "contacts": [{"slave": "block.bottom", "master": "table", "algorithm": setup.algorithm}],
            "supports": [{"on": "block.left", "ux": 0.0}],
            "effects": [
                {"use": "gravity", "acceleration": [0.0, -GRAVITY], "ramp": 0.5 * RESTS},
                {"use": "vibration-damping", "rate": 2e3, "until": RESTS},
            ],
        }  # fmt: skip
        watch = series("time", "position.block.y", "velocity.block.y", "push", most=40000)
        return (Job("tossed", scene, watch=(watch,), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The block vibrates when the table sets out with a jerk of its acceleration."""
        wave = SIZE * np.sqrt(DENSITY / self.young)
        share = float(6.0 * wave / self.flight()[0])
        why = f"vibrations of the block shift it by a part of their period, {share:.3f} of the rise"
        return (
            error("time at which it leaves over that of the rise", 1.5 * share, why),
            error("height of the flight", 3.0 * share, f"the speed at leaving squared; {why}"),
            error("time at which it lands over that of the rise", 1.5 * share, why),
            at_most("force in the flight over the weight", 0.0, "nothing touches"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate the contact force and the block's centre."""
        found, (rise, leaves, lands, height) = table(done["tossed"]), self.flight()
        time, push = found["time"] - RESTS, found["push"]
        middle = 0.5 * (leaves + lands)
        before, after = (np.flatnonzero((push > 0.0) & side) for side in (time < middle, time > middle))
        left, landed = float(time[before[-1]]), float(time[after[0]]) if len(after) else np.nan
        flies = (time > left + 0.02 * rise) & (time < landed - 0.02 * rise)
        y = found["position.block.y"]
        rest = float(np.interp(0.0, time, y))
        weight = DENSITY * SIZE**2 * GRAVITY
        return {
            "time at which it leaves over that of the rise": (left - leaves) / rise,
            "height of the flight": (float(y[flies].max()) - rest - LIFT) / height - 1.0,
            "time at which it lands over that of the rise": (landed - lands) / rise,
            "force in the flight over the weight": float(push[flies].max()) / weight,
        }
