"""A bar that flies to and fro between two rigid walls: rho c v for 2 L/c at each, and no loss but of its end nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, invariant, near, within
from contactlab_cases.bars import HEIGHT, LENGTH, SOUND, bars_job, start_energy
from contactlab_cases.dynamics import rise
from contactlab_cases.series import table

FREE = 1.0  # m, of the way from wall to wall


@dataclass(frozen=True)
class BarBetweenWalls(Case):
    """`impacts` until the end; `cells` along the bar. One flight and one impact take FREE/v + 2 L/c."""

    impacts: int = 4
    cells: int = 50

    title: ClassVar[str] = "bar that flies between walls"
    source: ClassVar[str] = "Timoshenko & Goodier, 15: rho c v for 2 L/c"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"impacts": (4, 20), "cells": (50, 100)}
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "energy"})
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run, which ends in the middle of a flight."""
        end = (self.impacts + 0.5) * FREE + self.impacts * 2.0 * LENGTH / SOUND - 0.5 * FREE
        walls = {"right": 0.5 * FREE + LENGTH, "left": -0.5 * FREE}
        contacts = [{"slave": f"bar0.{k}", "master": k, "algorithm": setup.algorithm} for k in walls]
        rigid = {
            "right": {"line": [[walls["right"], 2.0], [walls["right"], -2.0]]},
            "left": {"line": [[walls["left"], -2.0], [walls["left"], 2.0]]},
        }
        quantities = ("time", "velocity.bar0.x", "displacement.bar0.x")
        cells = self.cells * setup.level
        more: dict[str, Any] = {"courant": 0.95, "rigid": rigid, "contacts": contacts}
        return (bars_job(setup, cells, [1.0], [1.0], 0.0, end, quantities, "bar0", **more),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Each impact stops half a cell, whose energy goes into vibrations or is lost."""
        cell = self.impacts / self.cells / setup.level
        return (
            near("speed in the end", 1.0, cell, "half a cell of its energy at each impact, twice allowed"),
            error("way in the end over the free way", 2.0 * cell, "an impact lasts up to a cell longer"),
            error("mean force over rho c v at the first impact", 0.02, "waves of a few cells run a little late"),
            within("energy lost", -1e-9, cell, "half a cell at each impact, twice allowed"),
            invariant("largest rise of the energy in a step", 1e-9, "round-off; contact never adds energy"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with flights at constant speed."""
        energy, found = table(done["hit"], "bars"), table(done["hit"])
        first = found["time"] < 0.5 * FREE + 2.0 * LENGTH / SOUND + 0.4 * FREE
        force = np.abs(energy["force"][: len(first)][first]) / HEIGHT
        pressed = force[force > 0.1 * SOUND]
        start = start_energy([1.0], [1.0])
        return {
            "speed in the end": abs(float(found["velocity.bar0.x"][-1])),
            "way in the end over the free way": float(found["displacement.bar0.x"][-1]) / FREE,
            "mean force over rho c v at the first impact": float(np.mean(pressed[2:-2])) / SOUND - 1.0,
            "energy lost": float(1.0 - energy["energy"][-1] / start),
            "largest rise of the energy in a step": rise(energy["energy"]) / start,
        }
