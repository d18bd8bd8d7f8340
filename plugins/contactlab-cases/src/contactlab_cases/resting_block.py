"""A block that falls on a plane and comes to rest, in large steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, invariant, reported
from contactlab_cases.dynamics import WORK, largest, rise, strip
from contactlab_cases.series import series, table

WEIGHT, GRAVITY, STEP, DAMPING = 20.0, 10.0, 0.01, 20.0
LOW = 0.05  # of these falls the vibrations have died by a thousandth after 100 steps; a higher one ends later


@dataclass(frozen=True)
class RestingBlock(Case):
    """2 x 1, weight 20, damped, dropped from `fall`; steps of 0.01 s; `young` of a stiff or of a soft block."""

    fall: float = 0.05
    young: float = 1000.0

    title: ClassVar[str] = "block that comes to rest"
    source: ClassVar[str] = "energy and equilibrium"
    family: ClassVar[str] = "rest"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"fall": (0.01, 0.05, 0.2), "young": (200.0, 1000.0)}
    integrators: ClassVar[tuple[str, ...]] = ("implicit-dynamics",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    proves: ClassVar[frozenset[str]] = frozenset({"rest", "energy"})
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job of 200 steps, in which the block falls, at last at the speed g/damping, and comes to rest."""
        later = round(max(0.0, self.fall - LOW) * DAMPING / GRAVITY / STEP)
        block = strip((0.0, 2.0), (0.0, 1.0), [4 * setup.level, 2 * setup.level], shift=[0.0, self.fall])
        scene = {
            "name": "rest", "integrator": setup.integrator,
            "time": {"end": (200 + later) * STEP, "step": STEP, "damping": DAMPING},
            "materials": {"m": {"use": "linear-elastic", "young": self.young, "poisson": 0.3, "density": 1.0}},
            "bodies": {"block": block | {"element": setup.element}},
            "rigid": {"ground": {"line": [[4.0, 0.0], [-2.0, 0.0]]}},
            "contacts": [{"slave": "block.bottom", "master": "ground", "algorithm": setup.algorithm}],
            "effects": [{"use": "gravity", "acceleration": [0.0, -GRAVITY]}],
            "supports": [{"on": "block.left", "ux": 0.0}],
        }  # fmt: skip
        return (Job("dropped", scene, watch=(series("energy", "force.block.y", "displacement.block.y"),), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Measure the block at rest, and the energy that contact has made."""
        return (
            invariant("largest rise of energy in a step", 1e-9, "damping and contact never add energy"),
            error("reaction at rest", 0.001, "vibrations have died"),
            at_most("openings and closings in the last 100 steps", 0.0, "no endless opening and closing"),
            at_most("largest pull", 0.0, "nodal forces push", "N"),
            reported("openings and closings"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures; the weight's energy is its potential."""
        found = table(done["dropped"])
        force = found["force.block.y"]
        changes = np.flatnonzero(np.diff((force > 0.0).astype(int)))
        return {
            "largest rise of energy in a step": rise(found["energy"] + WEIGHT * found["displacement.block.y"]),
            "reaction at rest": largest(force[-100:] / WEIGHT - 1.0),
            "openings and closings in the last 100 steps": float(np.count_nonzero(changes > len(force) - 101)),
            "largest pull": float(max(0.0, -force.min())),
            "openings and closings": float(len(changes)),
        }
