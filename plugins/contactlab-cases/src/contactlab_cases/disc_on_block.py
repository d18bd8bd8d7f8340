"""The paper's first test: a disc pressed into a block ten times softer, deep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.statics import WORK, iterations

FEW = 100
"""Steps and iterations of a run without friction: mortars take half of them."""


@dataclass(frozen=True)
class DiscOnBlock(Case):
    """Radius 1, pressed `depth` deep, with a coefficient of friction `mu`."""

    depth: float = 0.1581
    mu: float = 0.0

    title: ClassVar[str] = "disc on block (test 1 of the paper)"
    source: ClassVar[str] = "Baillet & Sassi 2005, test 1"
    family: ClassVar[str] = "large deformation"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"depth": (0.01, 0.1581), "mu": (0.0, 0.05, 0.2)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2")
    proves: ClassVar[frozenset[str]] = frozenset({"curved contact", "large deformation"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The pair and the slaves exchanged; if both finish, a mesh twice as fine."""
        pair = (self._job("pressed", setup, setup.swap, 1), self._job("exchanged", setup, not setup.swap, 1))
        if any(name in done and not done[name].finished for name in ("pressed", "exchanged")):
            return pair
        return (*pair, self._job("finer", setup, setup.swap, 2)) if done else pair

    def _job(self, name: str, setup: Setup, swap: bool, finer: int) -> Job:
        changes: dict[str, Any] = {
            **setup.changes("disc", "block"), "contacts.0.swap": swap, "level": finer * setup.level,
            "integrator": {"use": setup.integrator, "steps": 20 if self.mu else 10}, "supports.1.uy.to": -self.depth,
        }  # fmt: skip
        if self.mu:
            changes["contacts.0.friction"] = {"use": "coulomb", "mu": self.mu}
        return Job(name, "disc-on-block", changes, work=WORK if self.mu else FEW)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The force does not know which side is the slave, and converges."""
        coarse = 0.04 if self.depth >= 0.04 else 0.15
        return (
            error("reaction against a mesh twice as fine", coarse / setup.level, "a node more or less in contact"),
            error("reaction with the slaves exchanged", coarse / setup.level, "both converge to the same force"),
            reported("reaction", "N/mm"),
            reported("iterations"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures from the vertical reactions of the block."""
        force = {name: float(r.reaction("block.bottom")[1]) for name, r in done.items() if r.finished}
        return {
            "reaction against a mesh twice as fine": force["pressed"] / force["finer"] - 1.0,
            "reaction with the slaves exchanged": force["pressed"] / force["exchanged"] - 1.0,
            "reaction": force["pressed"],
            "iterations": iterations(done["pressed"]),
        }
