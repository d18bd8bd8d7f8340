"""The paper's first test with Coulomb friction, loaded in time: neither slave nor speed decides the force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported, within
from contactlab_cases.dynamics import WORK

SHALLOW, DEEP = 0.01, 0.1581  # mm
RAMP = 8.9e-6  # s: 15 periods of the lowest mode of the disc and the block between their supports
ROUND = 1e-9
"""Sticking nodes keep a slip of at most 1e-10 segments a step, of either sign: what it works over internal energy."""
FORCES = {
    (0.05, SHALLOW): (60.349, 0.011, 4), (0.05, DEEP): (3973.44, 0.0015, 4),
    (0.2, SHALLOW): (60.420, 0.0018, 8), (0.2, DEEP): (4088.17, 0.00011, 8),
}  # fmt: skip
"""Answers (friction, depth): reaction [N/mm], its uncertainty, level of its static runs (build/docs/references.md)."""


@dataclass(frozen=True)
class DiscWithFriction(Case):
    """Pressed `depth` [mm] deep with the coefficient `mu`."""

    mu: float = 0.2
    depth: float = DEEP

    title: ClassVar[str] = "disc on block with friction, loaded in time (test 1 of the paper)"
    source: ClassVar[str] = "Baillet & Sassi 2005, test 1; Coulomb"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.05, 0.2), "depth": (SHALLOW, DEEP)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "curved contact", "large deformation"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The pair, the slaves exchanged, and the pair at half the speed."""
        return (
            self._job("pressed", setup, setup.swap, RAMP),
            self._job("exchanged", setup, not setup.swap, RAMP),
            self._job("slow", setup, setup.swap, 2.0 * RAMP),
        )

    def _job(self, name: str, setup: Setup, swap: bool, ramp: float) -> Job:
        changes: dict[str, Any] = {
            **setup.changes("disc", "block"), "contacts.0.swap": swap, "level": setup.level, "time.ramp": ramp,
            "contacts.0.friction": {"use": "coulomb", "mu": self.mu},
            "supports.1.uy": {"ramp": "parabola", "to": -self.depth},
        }  # fmt: skip
        return Job(name, "disc-on-block", changes, work=WORK, frames=20)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The force of finer meshes, whichever the slave and the speed; friction takes energy and gives none."""
        deep = self.depth == DEEP
        slack, few = (0.005, "a/h = 10") if deep else (0.03, "five nodes carry the force")
        value, known, level = FORCES[self.mu, self.depth]
        answer = Answer(value, "finest", known, "own static runs (build/docs/references.md)", level)
        return (
            error("reaction", slack / setup.level, few, answer=answer, codes=("coarse-facets", "pressure-saw")),
            within("reaction with the slaves exchanged, less one", -slack, slack, few),
            within(
                "reaction at half the speed, less one", -0.005, 0.005, "quasi-static: inertia carries less than that"
            ),
            at_most(
                "force beyond the cone over the largest pressure", 1e-8, "friction is bounded node by node: round-off"
            ),
            within("least work of friction between frames over internal energy", -ROUND, 1.0, "it takes energy"),
            reported("reaction in the end", "N/mm"),
            reported("reaction with the slaves exchanged", "N/mm"),
            reported("reaction at half the speed", "N/mm"),
            reported("work of friction over internal energy"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate the reaction of the disc's support, and the energy balance of all three runs."""
        force = {name: abs(float(record.reaction("disc.top")[1])) for name, record in done.items()}
        contacts = [record.summary["contacts"]["contacts.0"] for record in done.values()]
        return {
            "reaction": force["pressed"] / FORCES[self.mu, self.depth][0] - 1.0,
            "reaction with the slaves exchanged, less one": force["exchanged"] / force["pressed"] - 1.0,
            "reaction at half the speed, less one": force["slow"] / force["pressed"] - 1.0,
            "force beyond the cone over the largest pressure": max(float(c["cone_violation"]) for c in contacts),
            "least work of friction between frames over internal energy": min(map(_least, done.values())),
            "reaction in the end": force["pressed"],
            "reaction with the slaves exchanged": force["exchanged"],
            "reaction at half the speed": force["slow"],
            "work of friction over internal energy": float(done["pressed"].history["energy.slip"][-1])
            / done["pressed"].summary["balance"]["internal"],
        }


def _least(record: Record) -> float:
    return float(np.diff(record.history["energy.slip"]).min() / record.summary["balance"]["internal"])
