"""A bar hits a row of bars at rest that touch: only the last one flies on, as in Newton's cradle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, invariant, near, within
from contactlab_cases.bars import HEIGHT, LENGTH, SOUND, bars_job, start_energy
from contactlab_cases.dynamics import momentum_change, rise
from contactlab_cases.series import table


@dataclass(frozen=True)
class RowOfBars(Case):
    """`bars` of one length and material in the row, and the one that hits them; `cells` along each.

    The pulse of length 2 L runs through the row and leaves every bar behind at rest, the last one at full speed.
    """

    bars: int = 2
    cells: int = 50

    title: ClassVar[str] = "a bar hits a row of bars"
    source: ClassVar[str] = "de Saint-Venant 1867: waves in bars"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"bars": (2, 4), "cells": (50, 100)}
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "momentum", "energy"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run at Courant number 1, until the pulse has passed."""
        names = [f"velocity.bar{k}.x" for k in range(self.bars + 1)]
        speeds, densities = [1.0] + self.bars * [0.0], (self.bars + 1) * [1.0]
        end = (self.bars + 2.0) * LENGTH / SOUND
        momenta = ("momentum.x", "momentum.y", *names)
        return (bars_job(setup, self.cells * setup.level, speeds, densities, 2.0, end, momenta),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Half a cell over the length at each joint."""
        cell = 0.5 * self.bars / self.cells / setup.level
        why = "end nodes of half a cell exchange their momenta as rigid ones do"
        return (
            near("speed of the last bar", 1.0, 0.01 + cell, why),
            at_most("largest speed of the others", 0.01 + cell, why),
            invariant("linear momentum, change", 1e-12, "forces come in pairs"),
            within("energy lost", -1e-9, cell, "a quarter of a cell of the energy at each joint, twice allowed"),
            invariant("largest rise of the energy in a step", 1e-9, "round-off; contact never adds energy"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate speeds at the end, momentum and energy."""
        energy, found = table(done["hit"], "bars"), table(done["hit"])
        speeds = [float(found[f"velocity.bar{k}.x"][-1]) for k in range(self.bars + 1)]
        start = start_energy([1.0], [1.0])
        return {
            "speed of the last bar": speeds[-1],
            "largest speed of the others": max(abs(v) for v in speeds[:-1]),
            "linear momentum, change": momentum_change(found, LENGTH * HEIGHT),
            "energy lost": float(1.0 - energy["energy"][-1] / start),
            "largest rise of the energy in a step": rise(energy["energy"]) / start,
        }
