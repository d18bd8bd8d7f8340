"""A disc that is ten thousand times as stiff as the block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab_cases.circles import SOURCE, disc_on_block, hertz_measures, hertz_values, only

RADIUS, SOFT = 10.0, 7e4
HALF_WIDTH = 0.01575  # radii, at this depth


@dataclass(frozen=True)
class StiffnessContrast(Case):
    """Moduli `contrast` apart; `segments` of the soft block in a half-width, `ratio` of the disc's cells to its own."""

    contrast: float = 1e4
    segments: float = 16.0
    ratio: float = 1.0

    title: ClassVar[str] = "stiff cylinder on a soft block"
    source: ClassVar[str] = SOURCE
    family: ClassVar[str] = "hertz"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"contrast": (1e2, 1e4, 1e6), "ratio": (1.0 / 3.0, 1.0, 3.0)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"curved contact", "stiffness contrast"})
    margin: ClassVar[tuple[str, float] | None] = ("contrast", 1e9)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: two bodies of unlike stiffness pressed together."""
        h = HALF_WIDTH / self.segments / setup.level
        return (disc_on_block(setup, RADIUS, (self.contrast * SOFT, SOFT), 8e-4, h, self.ratio, growth=1.04),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Errors of the pressure, with tolerances for sixteen segments on the coarser side."""
        size = 16.0 / self.segments / setup.level * max(1.0, self.ratio)
        why = "exact nodal values are off by 2 % at 16 segments and by 6 % at 5; facets of a coarse stiff side press"
        return hertz_measures(0.03 * size, 1.0 if self.ratio <= 1.0 else float("inf"), 0.04 * size, why)

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare the pressure with Hertz's at the measured force."""
        return hertz_values(only(done), RADIUS, 1.0 / (0.91 / (self.contrast * SOFT) + 0.91 / SOFT))
