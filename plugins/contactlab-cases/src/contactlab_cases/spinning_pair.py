"""Two blocks that hold each other and turn freely: nothing slips, nothing is lost."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, invariant
from contactlab_cases.dynamics import WORK, momentum_change
from contactlab_cases.series import series, table

BEGIN, TURN, SPEED = 1e-3, 2e-3 * math.pi, 500.0  # s: vibrations of the start are over; a turn; mm/s of each centre
MASS = 1e-9 * 2.0  # t, of the upper block
SIZE = 2.0 / 6.0  # mm, of its segments


@dataclass(frozen=True)
class SpinningPair(Case):
    """`turns` of a pair drawn together; with friction it sticks, without it only the momenta are kept."""

    turns: float = 0.5
    friction: bool = True

    title: ClassVar[str] = "spinning pair"
    source: ClassVar[str] = "momenta and energy of a free body"
    family: ClassVar[str] = "invariance"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"friction": (True, False), "turns": (0.5, 1.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "momentum", "energy", "large rotation"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Damped until it has settled, then free; with friction another that stays damped, whose slips are watched."""
        free = self._job("free", setup, {"effects.1.until": BEGIN} | ({} if self.friction else NO_FRICTION))
        return (
            (free, self._job("damped", setup, {}, {"use": "slips", "begin_time": BEGIN})) if self.friction else (free,)
        )

    def _job(self, name: str, setup: Setup, changes: Mapping[str, Any], *watch: Mapping[str, Any]) -> Job:
        base = {**setup.changes("upper", "lower"), "time.end": BEGIN + self.turns * TURN, "level": setup.level}
        free = name == "free"
        found = series(*(FREE if free else DIRECTION), begin_time=BEGIN, every=10 if free else 1)
        return Job(name, "spinning-pair", {**base, **changes}, (found, *watch), work=WORK)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bound changes per turn, so that ten turns have the same bounds."""
        found = [
            invariant("linear momentum, change", 1e-12, "forces come in pairs"),
            invariant("angular momentum, change per turn", 1e-6, "forces of a pair lie in one line but for the gap"),
            invariant("energy, change per turn", 1e-5, "leapfrog's own, of second order in the step"),
        ]
        if not self.friction:
            return found
        return [
            *found,
            at_most("largest slip of a stuck pair in a turn in segments", 1e-8, "the solver's residual", "h"),
            at_most("direction of the force against that of the pair, change", 1e-5, "independent of the axes", "rad"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures from the motion after damping has ended."""
        found = table(done["free"])
        spin, energy = found["angular-momentum"], found["energy"]
        values = {
            "linear momentum, change": momentum_change(found, MASS * SPEED),
            "angular momentum, change per turn": abs(spin[-1] / spin[0] - 1.0) / self.turns,
            "energy, change per turn": abs(energy[-1] / energy[0] - 1.0) / self.turns,
        }
        if not self.friction:
            return values
        damped = done["damped"]
        rows = table(damped)
        angle = np.arctan2(rows["force.upper.y"], rows["force.upper.x"]) - rows["tilt.upper"]
        slip = float(damped.watched["slips"]["largest"][0])
        values["largest slip of a stuck pair in a turn in segments"] = slip / (SIZE / setup.level) / self.turns
        values["direction of the force against that of the pair, change"] = float(np.ptp(np.unwrap(angle)))
        return values


NO_FRICTION = {"contacts.0.friction": None}
FREE = ("momentum.x", "momentum.y", "angular-momentum", "energy")
DIRECTION = ("force.upper.x", "force.upper.y", "tilt.upper")
