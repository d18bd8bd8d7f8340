"""A bar against a wall: rho c v for 2 L/c, then flight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, invariant, reported
from contactlab_cases.dynamics import WORK, rise, strip
from contactlab_cases.series import series, table

LENGTH, SPEED, SOUND = 10.0, 10.0, 30.0
ENERGY = 0.5 * LENGTH * SPEED**2  # per unit of height, which is 1


@dataclass(frozen=True)
class WallImpact(Case):
    """`cells` of unit height; `courant` number; `phase` is the part of a step that is left when the bar arrives."""

    courant: float = 1.0
    phase: float = 0.0
    cells: int = 50

    title: ClassVar[str] = "bar against a wall"
    source: ClassVar[str] = "Timoshenko & Goodier, 15: rho c v for 2 L/c"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"courant": (0.9, 1.0, 5.0), "phase": (0.0, 0.5)}
    integrators: ClassVar[tuple[str, ...]] = ("implicit-dynamics",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "energy"})
    swaps: ClassVar[bool] = False
    margin: ClassVar[tuple[str, float] | None] = ("courant", 20.0)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: the bar hits the wall and leaves it."""
        cells = self.cells * setup.level
        dt = self.courant * LENGTH / cells / SOUND
        arrival = (round(0.5 / dt) - self.phase) * dt
        bar = strip((0.0, LENGTH), (0.0, 1.0), [cells, 1], velocity=[-SPEED, 0.0], shift=[SPEED * arrival, 0.0])
        scene = {
            "name": "impact", "time": {"end": round(1.4 / dt) * dt, "step": dt}, "integrator": setup.integrator,
            "materials": {"m": {"use": "linear-elastic", "young": SOUND**2, "poisson": 0.0, "density": 1.0}},
            "bodies": {"bar": bar | {"element": setup.element}},
            "rigid": {"wall": {"line": [[0.0, -1.0], [0.0, 2.0]]}},
            "contacts": [{"slave": "bar.left", "master": "wall", "algorithm": setup.algorithm}],
            "supports": [{"on": "bar", "uy": 0.0}],
        }  # fmt: skip
        return (Job("hit", scene, watch=(series("time", "force.bar.x", "energy"),), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The midpoint rule keeps energy but for the nodes that are stopped."""
        early = ("early-contact",)
        return (
            error("mean force", 0.002, "rho c v, and a node's share of fifty", codes=early),
            error(
                "loss against that of the stopped nodes", 0.02, "half a cell; steps end where it arrives", codes=early
            ),
            at_most("contacts after the first", 0.0, "it leaves once"),
            invariant("largest rise of energy in a step", 1e-9, "round-off; contact never adds energy"),
            reported("ripple of the force"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with a force of 300, and with the kinetic energy."""
        found, cells = table(done["hit"]), self.cells * setup.level
        time, force, energy = found["time"], found["force.bar.x"], found["energy"]
        active, middle = np.flatnonzero(force > 1.0), force[(time > 0.55) & (time < 1.1)]
        return {
            "mean force": float(middle.mean()) / (SOUND * SPEED) - 1.0,
            "loss against that of the stopped nodes": (1.0 - energy[-1] / ENERGY) / (0.5 / cells) - 1.0,
            "contacts after the first": float(np.count_nonzero(np.diff(active) > 1)),
            "largest rise of energy in a step": rise(energy) / ENERGY,
            "ripple of the force": float(middle.std()) / (SOUND * SPEED),
        }
