"""A slider that is pushed over the edge of its base, on a smooth base or on a kinked one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error
from contactlab_cases.dynamics import WORK, largest
from contactlab_cases.series import series, table

SPEED, END, MU = 1e4, 8e-4, 0.2  # mm/s, s
SETTLED, AT_EDGE = 1e-4, 4e-4  # s: vibrations are over; the slider's front reaches the edge
EDGE, SEGMENT, LENGTH = 10.0, 0.25, 4.0  # mm
TIPPED = 0.01  # rad: reached within 0.25 mm of travel after the balance is lost
COUNT = 36
TIPS = "centre when it tips, beyond that of a rigid slider in segments"


@dataclass(frozen=True)
class CornerSlide(Case):
    """`kink` in degrees of the base at every segment: 0 for the smooth elastic one.

    On kinks the base is a rigid zigzag line, and the slider soft and pressed hard enough to lie in it: else it would
    jump from crest to crest.
    """

    kink: float = 0.0

    title: ClassVar[str] = "slide over a corner"
    source: ClassVar[str] = "equilibrium of a rigid slider on an edge"
    family: ClassVar[str] = "large sliding"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"kink": (0.0, 0.5, 1.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "large sliding"})
    margin: ClassVar[tuple[str, float] | None] = ("kink", 10.0)

    def applies(self, setup: Setup) -> str:
        """Leave out deformable masters with a zigzag, which is rigid."""
        return "a rigid surface cannot be the slave" if self.kink and setup.swap else ""

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run, until the slider has left or only until it reaches the edge; twice as slow on level 2."""
        slow = setup.level
        base = {
            **setup.changes(*(("slider",) if self.kink else ("slider", "base"))), "contacts.0.friction.mu": MU,
            "time.end": slow * (AT_EDGE if self.kink else END), "bodies.slider.velocity": [SPEED / slow, 0.0],
        }  # fmt: skip
        watch = series("time", "force.slider.x", "force.slider.y", "tilt.slider", "position.slider.x")
        return (Job("slid", "corner-slide", {**base, **(self._zigzag() if self.kink else {})}, (watch,), work=WORK),)

    def _zigzag(self) -> dict[str, Any]:
        height = EDGE / COUNT * math.tan(math.radians(0.5 * self.kink))
        line = [[EDGE, -2.0]] + [[EDGE * (1.0 - i / COUNT), -height * (i % 2)] for i in range(COUNT + 1)]
        return {
            "materials.rubber.young": 1000.0, "loads.0.ty.to": -10.0, "loads.1.tx.to": 8.0, "supports": [],
            "bodies.base": None, "rigid": {"base": {"line": line, "segment": 0.3}}, "contacts.0.master": "base",
        }  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Forces until the overhang is reached, and where the block tips."""
        why = "vibrations have died to a thousandth of the load"
        found = [
            at_most("normal force until the edge, largest deviation", 0.01, why),
            at_most("friction over mu times it, largest deviation", 0.01, why),
        ]
        if self.kink:
            return found
        return [
            *found,
            error(TIPS, 2.0, "it bends before it tips", "h"),
            at_most("largest force after it has left the base", 0.0, "nothing is in reach", "N"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """The push at half height turns a rigid slider when its centre is still half of mu before the edge."""
        found, slow = table(done["slid"]), setup.level
        time, along, normal = found["time"], found["force.slider.x"], found["force.slider.y"]
        before = (time > slow * SETTLED) & (time <= slow * AT_EDGE)
        load = LENGTH * (10.0 if self.kink else 1.0)
        values = {
            "normal force until the edge, largest deviation": largest(normal[before] / load - 1.0),
            "friction over mu times it, largest deviation": largest(along[before] / normal[before] / MU + 1.0),
        }
        if self.kink:
            return values
        tipped = np.flatnonzero(found["tilt.slider"] < -TIPPED)
        if len(tipped):
            early = float(found["position.slider.x"][tipped[0]]) - (EDGE - 0.5 * MU)
            values[TIPS] = early / SEGMENT
        # its rear is half a length behind its centre, and a segment more where it turns
        gone = found["position.slider.x"] > EDGE + 0.5 * LENGTH + SEGMENT
        if gone.any():
            values["largest force after it has left the base"] = max(largest(along[gone]), largest(normal[gone]))
        return values
