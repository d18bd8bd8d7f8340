"""An elastic bar that falls on the ground, is thrown back vibrating, and lands again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import error, invariant, near, reported
from contactlab_cases.dynamics import WORK, pushed, rise
from contactlab_cases.series import series, table

PERIOD, FIRST, CONTACT = 16.0 / 3.0, 1.0, 2.0 / 3.0  # s: of the motion, until the first impact, of a contact
GRAVITY, HEIGHT, WIDTH, LENGTH, SOUND = 10.0, 5.0, 0.2, 10.0, 30.0
CELLS = 100
DOYEN = Answer(0.0038, "other-code", 0.05, "Doyen, Ern & Piperno 2011, with as many cells")


@dataclass(frozen=True)
class BouncingBar(Case):
    """Three periods; `cells` along the bar. Explicit at Courant number 1, implicit at 0.7."""

    cells: int = CELLS
    periods: int = 3

    title: ClassVar[str] = "bouncing bar"
    source: ClassVar[str] = "Doyen, Ern & Piperno 2011"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"cells": (50, 100), "periods": (1, 3)}
    integrators: ClassVar[tuple[str, ...]] = ("central-difference", "implicit-dynamics")
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "energy"})
    swaps: ClassVar[bool] = False

    def applies(self, setup: Setup) -> str:
        """Implicit runs show on half as many cells what they show on all."""
        dear = setup.integrator != "central-difference" and self.cells >= CELLS
        return (
            "implicit runs with so many cells are expensive: half as many are enough"
            if dear
            else super().applies(setup)
        )

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run without guards: they would stop it, as waves of strain 0.6 move faster than sound in flight."""
        cells, explicit = self.cells * setup.level, setup.integrator == "central-difference"
        changes = {
            **setup.changes("bar"),
            "time.step": (1.0 if explicit else 0.7) * LENGTH / cells / SOUND,
            "time.end": self.periods * PERIOD,
            # waves are exact at Courant 1, the limit of sideways modes, too: held, their round-off does not grow
            "supports": [{"on": "bar", "ux": 0.0}],
            "bodies.bar.mesh.x": [0.0, WIDTH * CELLS / cells], "bodies.bar.mesh.cells": [1, cells],
        }  # fmt: skip
        if explicit:  # at Courant 1 the fastest zigzag has no energy: what consistent forces leave of it grows
            changes["contacts.0.enforcement"] = pushed("frozen")
        kept = {"use": "leapfrog-energy", "name": "bar", "body": "bar"}
        own = ("time", "force.bar.y", "energy", "displacement.bar.y", "velocity.bar.y")
        work = WORK * setup.level  # steps, so that rows never need more room
        top = series("time", "velocity.bar.y", name="top", most=work)
        watch = (kept, top) if explicit else (series(*own, name="bar", most=work),)
        return (Job("bar", "bouncing-bar", changes, watch, work=work, guards=False),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Each impact takes the energy of half a cell, and with it some of the height."""
        early, ends = 0.02 / setup.level * CELLS / self.cells, "half a cell of energy is lost at each of six impacts"
        bounds = [
            error("highest point after the last period, later than exact [periods]", early, ends),
            invariant("largest rise of the energy in a step", 1e-9, "round-off; contact never adds energy"),
        ]
        if setup.integrator != "central-difference":
            drawn = error("impulse of the first contact", 0.01, "the midpoint rule and lumped masses slow waves")
            return [drawn, *bounds, reported("energy lost")]
        lost = reported("energy lost")
        if self.cells * setup.level == 4 * CELLS:
            lost = near("energy lost", DOYEN.value, 0.1, "another code with other time integration")
        return [
            invariant("first contact, error of the force 300 + 300 t", 1e-8, "the mesh carries waves exactly", "N/mm"),
            lost, *bounds,
        ]  # fmt: skip

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures, energies as shares of the energy of the fall."""
        width = WIDTH * CELLS / (self.cells * setup.level)
        fall = width * LENGTH * GRAVITY * HEIGHT
        return (self._explicit if setup.integrator == "central-difference" else self._implicit)(
            done["bar"], width, fall
        )

    def _explicit(self, record: Record, width: float, fall: float) -> dict[str, float]:
        found, top = table(record, "bar"), table(record, "top")
        time, force, energy = found["time"], found["force"] / width, found["energy"] / fall
        step = float(time[0])
        first = (time > FIRST + 1.5 * step) & (time < FIRST + CONTACT - 0.5 * step)
        # the force of a step acts at its beginning
        exact = 300.0 + 300.0 * (time[first] - step - FIRST)
        late = time[-1] - self.periods * PERIOD + top["velocity.bar.y"][-1] / GRAVITY
        return {
            "first contact, error of the force 300 + 300 t": float(np.abs(force[first] - exact).max()),
            "energy lost": float(energy[0] - energy[-1]),
            "largest rise of the energy in a step": rise(energy),
            "highest point after the last period, later than exact [periods]": float(late / PERIOD),
        }

    def _implicit(self, record: Record, width: float, fall: float) -> dict[str, float]:
        found = table(record, "bar")
        time, mass = found["time"], width * LENGTH
        energy = (found["energy"] + mass * GRAVITY * found["displacement.bar.y"]) / fall
        first = (time > 0.95) & (time < 2.0)
        impulse = float(found["force.bar.y"][first].sum()) * float(time[0]) / width
        late = time[-1] - self.periods * PERIOD + found["velocity.bar.y"][-1] / GRAVITY
        return {
            "impulse of the first contact": impulse / (800.0 / 3.0) - 1.0,
            "energy lost": float(energy[0] - energy[-1]),
            "largest rise of the energy in a step": rise(energy),
            "highest point after the last period, later than exact [periods]": float(late / PERIOD),
        }
