"""A bar that hits one at rest, as long as itself or longer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, invariant, near, within
from contactlab_cases.dynamics import WORK, momentum_change, rise
from contactlab_cases.series import series, table

LENGTH, SOUND, END = 10.0, 30.0, 1.2


@dataclass(frozen=True)
class TwoBars(Case):
    """`ratio` of the lengths, struck over striking; `cells` along the striking one."""

    ratio: int = 1
    cells: int = 100

    title: ClassVar[str] = "two bars"
    source: ClassVar[str] = "de Saint-Venant 1867; Timoshenko & Goodier, 15"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"ratio": (1, 2, 3), "cells": (50, 100)}
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "momentum", "energy"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job at Courant number 1."""
        cells = self.cells * setup.level
        height, step = 20.0 / cells, LENGTH / cells / SOUND
        long = {
            "use": "rectangle", "x": [0.0, self.ratio * LENGTH], "y": [0.0, height], "cells": [self.ratio * cells, 1],
        }  # fmt: skip
        changes = {
            **setup.changes("left", "right"), "time.step": step, "time.end": END, "bodies.right.mesh": long,
            "bodies.left.mesh.y": [0.0, height], "bodies.left.mesh.cells": [cells, 1],
            "bodies.right.shift": [10.0 * step, 0.0],
        }  # fmt: skip
        kept = {"use": "leapfrog-energy", "name": "bars", "body": "right"}
        momenta = series("momentum.x", "momentum.y", "velocity.left.x", "velocity.right.x")
        return (Job("hit", "two-bars", changes, (kept, momenta), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Two end nodes of half a cell lose half of their relative speed: half a cell of the energy, twice allowed."""
        cells, wave = self.cells * setup.level, "the mesh carries waves exactly but for the last cell of each bar"
        cell = 1.0 / cells
        return (
            near("speed of the struck bar over that of the other before", 1.0 / self.ratio, 0.01, wave),
            at_most("speed of the other, the same way", 0.01, wave),
            near("force per height", 15.0, 0.01, "rho c v/2", "N/mm"),
            near("duration of the contact", 2.0 / 3.0, 0.01 + cell, "2 L/c, and a cell", "s"),
            invariant("linear momentum, change", 1e-12, "forces come in pairs"),
            within("energy lost", -1e-9, 0.5 * cell, "half a cell of the energy, twice allowed"),
            invariant("largest rise of the energy in a step", 1e-9, "round-off; contact never adds energy"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare forces and times with elastic waves in bars."""
        cells = self.cells * setup.level
        height = 20.0 / cells
        energy, found = table(done["hit"], "bars"), table(done["hit"])
        active = np.flatnonzero(energy["force"] / height > 1.0)
        lasted = np.diff(energy["time"], prepend=0.0)[active]  # steps of an integrator may have lengths of their own
        start = 0.5 * LENGTH * height
        return {
            "speed of the struck bar over that of the other before": float(found["velocity.right.x"][-1]),
            "speed of the other, the same way": abs(float(found["velocity.left.x"][-1])),
            "force per height": float(np.average(energy["force"][active[2:-2]] / height, weights=lasted[2:-2])),
            "duration of the contact": float(lasted.sum()),
            "linear momentum, change": momentum_change(found, LENGTH * height),
            "energy lost": float(1.0 - energy["energy"][-1] / start),
            "largest rise of the energy in a step": rise(energy["energy"]) / start,
        }
