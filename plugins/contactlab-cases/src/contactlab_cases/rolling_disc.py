"""A disc that is thrown or spun along a floor: it slides until it rolls, at a speed that friction has no say in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.discs import MASS, RADIUS, soft, soft_disc
from contactlab_cases.dynamics import WORK
from contactlab_cases.series import series, table

GRAVITY, YOUNG = 9810.0, 1.0  # mm/s2; MPa: soft enough that contact spans several segments under its bounces


@dataclass(frozen=True)
class RollingDisc(Case):
    """`speed` [mm/s] along the floor and `spin` [1/s] at the start, `mu` of Coulomb's law.

    Momentum and angular momentum about the line on the floor are kept: m v R + m R^2/2 W, W clockwise. While it slides
    v' = -mu g sign(v - W R); it rolls from |v - W R|/(3 mu g) on with (2 v + W R)/3.
    """

    speed: float = 200.0
    spin: float = 0.0
    mu: float = 0.3

    title: ClassVar[str] = "disc thrown along a floor until it rolls"
    source: ClassVar[str] = "Coulomb; Euler 1758; Routh 1860"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "speed": (0.0, 200.0), "spin": (20.0, 0.0, -10.0), "mu": (0.2, 0.3)
    }  # fmt: skip
    demands: ClassVar[frozenset[str]] = frozenset({"explicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "momentum"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def applies(self, setup: Setup) -> str:
        """Leave out a disc whose outside rests on the floor: it does not slide."""
        turning = -self.spin * RADIUS
        return super().applies(setup) or ("" if self.speed != turning else "the disc rolls from the start")

    @property
    def _rolls(self) -> tuple[float, float]:
        """Time [s] from which it rolls, and the speed [mm/s] with which."""
        turning = -self.spin * RADIUS
        return abs(self.speed - turning) / (3.0 * self.mu * GRAVITY), (2.0 * self.speed + turning) / 3.0

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run, three times as long as it would slide without bouncing."""
        rolls, _ = self._rolls
        disc = soft_disc(
            20 * setup.level, shift=[0.0, RADIUS], velocity=[self.speed, 0.0], spin=self.spin, element=setup.element
        )
        scene = {
            "name": "rolling-disc", "time": {"end": 3.0 * rolls}, "integrator": setup.integrator,
            "materials": {"soft": soft(YOUNG)}, "bodies": {"disc": disc},
            "rigid": {"floor": {"line": [[60.0, 0.0], [-40.0, 0.0]], "segment": 10.0}},
            "contacts": [
                {
                    "slave": "disc.arc", "master": "floor", "algorithm": setup.algorithm,
                    "friction": {"use": "coulomb", "mu": self.mu},
                }
            ],
            "effects": [{"use": "gravity", "acceleration": [0.0, -GRAVITY]}],
        }  # fmt: skip
        watch = series("time", "velocity.disc.x", "energy", "push")
        return (Job("thrown", scene, watch=(watch,), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """A soft disc bounces on its weight, and turns more within than outside."""
        return (
            error(
                "speed when it rolls over that of a rigid disc, less one",
                0.03,
                "the disc bounces on its weight, and its outside lags behind while it turns: a hundredth each way",
            ),
            error(
                "momentum lost while it slides over mu times the impulse of the floor, less one",
                0.02,
                "all of it slides: Coulomb's law at every node; normals lean at the ends of contact, by half a turn",
            ),
            reported("part of the energy that is left"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Find the speed of the last third of the time; impulses during the first half of the sliding."""
        found = table(done["thrown"])
        rolls, speed = self._rolls
        time, v = found["time"], found["velocity.disc.x"]
        slides = time < 0.5 * rolls
        impulse = self.mu * float(found["push"][slides].sum()) * float(time[1] - time[0])
        lost = abs(float(v[slides][-1]) - self.speed) * MASS
        return {
            "speed when it rolls over that of a rigid disc, less one": float(v[time > 2.0 * rolls].mean()) / speed
            - 1.0,
            "momentum lost while it slides over mu times the impulse of the floor, less one": lost / impulse - 1.0,
            "part of the energy that is left": float(found["energy"][-1] / found["energy"][0]),
        }
