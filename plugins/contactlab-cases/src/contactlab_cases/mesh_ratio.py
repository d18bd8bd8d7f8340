"""A cylinder on a block with cells many times as long on one side as on the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import SOURCE, disc_on_block, hertz, hertz_values
from contactlab_cases.statics import force_of, plane_strain

RADIUS, YOUNG = 10.0, 70000.0
HALF_WIDTH = 0.01745  # radii, at this depth


@dataclass(frozen=True)
class MeshRatio(Case):
    """`ratio` of the disc's cells to the block's; 8 of the longer ones in a half-width."""

    ratio: float = 10.0

    title: ClassVar[str] = "meshes 1:10"
    source: ClassVar[str] = SOURCE
    family: ClassVar[str] = "hertz"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"ratio": (0.1, 0.3, 3.0, 10.0)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"curved contact", "mesh ratio"})
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2")
    margin: ClassVar[tuple[str, float] | None] = ("ratio", 100.0)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan the pair, and another with matching meshes of sixteen cells."""
        longest = HALF_WIDTH / 8.0 / setup.level
        block = longest / max(1.0, self.ratio)
        alike = replace(setup, element="q1")
        return (
            disc_on_block(setup, RADIUS, (YOUNG, YOUNG), 8e-4, block, self.ratio, growth=1.05, name="unlike"),
            disc_on_block(alike, RADIUS, (YOUNG, YOUNG), 8e-4, HALF_WIDTH / 16.0, growth=1.05, name="alike"),
        )

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Compare force, depth and pressure with matching meshes."""
        fine_slave = (self.ratio > 1.0) == setup.swap
        why = "weak conditions on the fine side close the gap everywhere; on the coarse one only in the mean"
        deep = "penetration in short cells"
        return (
            error("force against like meshes", 0.01, "depth is given, and compliance belongs to the bodies"),
            at_most(deep, 0.02, why) if fine_slave else reported(deep),
            reported("largest pressure"),
            reported("half-width in segments"),
            reported("L2 of the pressure"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare the pressure with Hertz's at the measured force."""
        unlike, alike, modulus = done["unlike"], done["alike"], plane_strain(YOUNG) / 2.0
        a, _, _ = hertz(force_of(unlike), RADIUS, modulus)
        short = a / (8.0 * setup.level * max(self.ratio, 1.0 / self.ratio))
        depth = float(unlike.summary["contacts"]["contacts.0"]["max_penetration"])
        found = {
            **hertz_values(unlike, RADIUS, modulus),
            "force against like meshes": force_of(unlike) / force_of(alike) - 1.0,
            "penetration in short cells": depth / short,
        }
        return {measure.name: found[measure.name] for measure in self.measures(setup) if measure.name in found}
