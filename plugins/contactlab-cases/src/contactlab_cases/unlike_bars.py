"""A bar hits one of another impedance: the force is v Z1 Z2/(Z1 + Z2) until the wave is back, then both fly apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import invariant, near, within
from contactlab_cases.bars import HEIGHT, LENGTH, SOUND, bars_job, start_energy
from contactlab_cases.dynamics import momentum_change, rise
from contactlab_cases.series import table


@dataclass(frozen=True)
class UnlikeBars(Case):
    """`impedance` of the struck bar over the striking bar's; `cells` along each."""

    impedance: float = 4.0
    cells: int = 50

    title: ClassVar[str] = "bars of unlike impedance"
    source: ClassVar[str] = "de Saint-Venant 1867; Timoshenko & Goodier, 15"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"impedance": (1.5, 4.0, 20.0), "cells": (50, 100)}
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "momentum", "energy"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run at Courant number 1."""
        momenta = ("momentum.x", "momentum.y", "velocity.bar0.x", "velocity.bar1.x")
        return (bars_job(setup, self.cells * setup.level, (1.0, 0.0), (1.0, self.impedance), 10.0, 1.2, momenta),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Half a cell of each bar is stopped by the other: about a cell over the length of everything."""
        k, cell = self.impedance, 1.0 / self.cells / setup.level
        wave = "the mesh carries waves exactly but for the last cell of each bar"
        return (
            near("force per height", SOUND * k / (1.0 + k), 0.01, wave, "N/m"),
            near("duration of the contact", 2.0 * LENGTH / SOUND, 0.01 + cell, "2 L/c, and a cell", "s"),
            within("speed of the striking bar", (1.0 - k) / (1.0 + k) - cell, (1.0 - k) / (1.0 + k) + cell, wave),
            near("speed of the struck bar", 2.0 / (1.0 + k), 0.01 + cell, wave),
            invariant("linear momentum, change", 1e-12, "forces come in pairs"),
            within("energy lost", -1e-9, cell, "half a cell of both, twice allowed"),
            invariant("largest rise of the energy in a step", 1e-9, "round-off; contact never adds energy"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare forces and times with elastic waves."""
        energy, found = table(done["hit"], "bars"), table(done["hit"])
        active = np.flatnonzero(energy["force"] / HEIGHT > 0.1)
        start = start_energy((1.0, 0.0), (1.0, self.impedance))
        return {
            "force per height": float(np.mean(energy["force"][active[2:-2]])) / HEIGHT,
            "duration of the contact": len(active) * LENGTH / self.cells / setup.level / SOUND,
            "speed of the striking bar": float(found["velocity.bar0.x"][-1]),
            "speed of the struck bar": float(found["velocity.bar1.x"][-1]),
            "linear momentum, change": momentum_change(found, LENGTH * HEIGHT),
            "energy lost": float(1.0 - energy["energy"][-1] / start),
            "largest rise of the energy in a step": rise(energy["energy"]) / start,
        }
