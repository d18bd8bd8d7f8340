"""A damped block on a shaken table: it lands, chatters until it rests, and leaves at the same phase in every period.

A mass that does not bounce leaves the table where it brakes harder than gravity, flies, lands and stays until then:
what it does in a period does not depend on the one before. The block is one cell, as stiff and as damped that its
bounces after a landing die out long before it leaves again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import brentq

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.dynamics import WORK, largest
from contactlab_cases.series import series, table

GRAVITY, DENSITY, SIZE, YOUNG = 9810.0, 1e-9, 2.0, 2.0  # mm/s2, t/mm3, mm, MPa
WAVE = SIZE * math.sqrt(DENSITY / YOUNG)  # s, that a wave takes through the block
WEIGHT = DENSITY * SIZE**2 * GRAVITY
PERIOD, RESTS = 0.01, 0.002  # s, of the table; before it begins, in which the weight comes
FIRST, LAST = 1, 4  # periods that are judged; the first one begins with a jump of the table's speed
STEP = 0.08 * WAVE  # s: half of it would do for waves, a damping this strong needs shorter ones


@dataclass(frozen=True)
class Chatter(Case):
    """The table moves by -A sin(w t).

    shake    A w^2/g: above 1 the block leaves
    damping  rate of the damping of its vibrations times WAVE: 5.7 damps a block on the floor critically,
             less lets it bounce more often
    """

    shake: float = 2.0
    damping: float = 5.0

    title: ClassVar[str] = "block that chatters on a shaken table"
    source: ClassVar[str] = "Mehta & Luck 1990, the completely inelastic bouncing ball"
    family: ClassVar[str] = "rest"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"shake": (1.5, 2.0, 2.5), "damping": (5.0, 6.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "release", "rest"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    @property
    def _amplitude(self) -> float:
        return self.shake * GRAVITY * (PERIOD / (2.0 * math.pi)) ** 2

    def flight(self) -> tuple[float, float, float]:
        """Time of leaving after the table rises through its middle, time of flight [s]; height of the flight [mm]."""
        w, a = 2.0 * math.pi / PERIOD, self._amplitude
        phase = math.asin(1.0 / self.shake)  # A w^2 sin = g: there the table brakes as gravity does
        start, speed = a / self.shake, a * w * math.cos(phase)

        def above(t: float) -> float:
            return start + speed * t - 0.5 * GRAVITY * t**2 - a * math.sin(phase + w * t)

        # it draws away as t^3, and is far below the table a whole flight over level ground later
        top = speed / GRAVITY
        lands = float(brentq(above, top, 2.0 * top + math.sqrt(8.0 * a / GRAVITY)))
        return phase / w, lands, start + 0.5 * speed**2 / GRAVITY

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Five periods; a higher level has shorter steps."""
        mesh = {"use": "rectangle", "x": [0.0, SIZE], "y": [0.0, SIZE], "cells": [1, 1]}
        law = {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}
        wave = {"use": "sine", "period": PERIOD}
        moves = {"ramp": "function", "to": -self._amplitude, "begin": RESTS, "function": wave}
        scene = {
            "name": "chatter", "time": {"end": RESTS + (LAST + 1) * PERIOD, "step": STEP / setup.level},
            "integrator": setup.integrator, "materials": {"m": law},
            "bodies": {"block": {"material": "m", "element": setup.element, "mesh": mesh}},
            "rigid": {"table": {"line": [[3.0 * SIZE, 0.0], [-2.0 * SIZE, 0.0]], "uy": moves}},
            "contacts": [{"slave": "block.bottom", "master": "table", "algorithm": setup.algorithm}],
            "supports": [{"on": "block.left", "ux": 0.0}],
            "effects": [
                {"use": "gravity", "acceleration": [0.0, -GRAVITY], "ramp": 0.5 * RESTS},
                {"use": "vibration-damping", "rate": self.damping / WAVE},
            ],
        }  # fmt: skip
        watch = series("time", "position.block.y", "push", most=40000 * setup.level)
        return (Job("shaken", scene, watch=(watch,), work=WORK * setup.level),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bound times by some steps: forces end and begin with a step, and the block is as stiff as a spring."""
        step = STEP / setup.level / PERIOD
        why = "four steps of the period"
        return (
            error("time at which it leaves over the period", 4.0 * step, why),
            error("time at which it lands over the period", 4.0 * step, why),
            error("height over the middle of the table", 2e-3, "the speed at leaving, which four steps change by that"),
            error("mean force over the weight, less one", 4.0 * step, f"momentum: at rest on the table twice; {why}"),
            at_most(
                "openings and closings before it leaves again", 0.0, "bounces die in three quarters of the way there"
            ),
            at_most("openings and closings after a landing", 12.0, "each bounce is at most half as fast"),
            reported("time until it rests after a landing over the period"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """The largest of all periods, which are alike."""
        found = table(done["shaken"])
        time, push = found["time"] - RESTS, found["push"]
        y = found["position.block.y"] - float(np.interp(0.0, time, found["position.block.y"]))
        periods = [self._period(time, y, push, n) for n in range(FIRST, LAST)]
        worst = {name: largest(np.array([one[name] for one in periods])) for name in periods[0]}
        begin, end = (np.searchsorted(time, (n + 0.5) * PERIOD) for n in (FIRST, LAST))
        return {**worst, "mean force over the weight, less one": float(push[begin:end].mean()) / WEIGHT - 1.0}

    def _period(self, time: Floats, y: Floats, push: Floats, number: int) -> dict[str, float]:
        """Measure one period: flight, landing and rest until the next flight."""
        leaves, flies, height = self.flight()
        begin = (number + 0.5) * PERIOD + leaves
        lands, again, on = begin + flies, begin + PERIOD, push > 0.0
        middle = begin + 0.5 * flies
        left = float(time[on & (time < middle)][-1])
        landed = float(time[on & (time > middle)][0])
        changes = time[1:][on[1:] != on[:-1]]
        rest, short = lands + 0.75 * (again - lands), 0.01 * PERIOD
        late = changes > rest
        bounces = changes[(changes > landed) & ~late]
        return {
            "time at which it leaves over the period": (left - begin) / PERIOD,
            "time at which it lands over the period": (landed - lands) / PERIOD,
            "height over the middle of the table": float(y[(time > left) & (time < landed)].max()) / height - 1.0,
            "openings and closings before it leaves again": float(np.count_nonzero(late & (changes < again - short))),
            "openings and closings after a landing": float(len(bounces)),
            "time until it rests after a landing over the period": (float(bounces.max(initial=landed)) - landed)
            / PERIOD,
        }
