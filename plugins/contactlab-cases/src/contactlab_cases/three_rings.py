"""Three rings shrunk onto each other: Lame's pressures in both joints, from the interferences alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error
from contactlab_cases.circles import only
from contactlab_cases.nested import STEEL, nested_rings
from contactlab_cases.rings import shrunk_rings

RADII = ((0.2, 0.4), (0.4, 0.7), (0.7, 1.0))  # mm
CELLS = 24  # on a quarter, at level 1


@dataclass(frozen=True)
class ThreeRings(Case):
    """`interference` of both joints over their radii; `stiff` is the middle ring's modulus over the others'."""

    interference: float = 1e-4
    stiff: float = 1.0

    title: ClassVar[str] = "three rings shrunk onto each other"
    source: ClassVar[str] = "Lame 1852; Timoshenko & Goodier, Theory of Elasticity, 28"
    family: ClassVar[str] = "smooth"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"interference": (1e-4, 1e-3), "stiff": (0.1, 1.0, 10.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure", "overlap"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: each ring is larger outside than the next ring's hole."""
        n = CELLS * setup.level
        radii = [(ri, ro * (1.0 + self.interference)) for ri, ro in RADII[:2]] + [RADII[2]]
        return (nested_rings(setup, radii, (n, n, n), self._moduli(), {"start": {"overlap": "ramp"}}),)

    def _moduli(self) -> list[tuple[float, float]]:
        return [STEEL, (STEEL[0] * self.stiff, STEEL[1]), STEEL]

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Both mean pressures."""
        why = "8 bilinear cells through each ring: a hundredth at level 1; strains add their own size"
        return [
            error(f"mean pressure, {joint}", 0.01 / setup.level + 3.0 * self.interference, why)
            for joint in ("inner joint", "outer joint")
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with both pressures of the compound cylinder."""
        record, overlaps = only(done), [self.interference * ro for _, ro in RADII[:2]]
        exact = shrunk_rings(RADII, self._moduli(), overlaps)
        found = [float(np.mean(record.curve(f"contacts.{k}").pressure)) for k in (0, 1)]
        return {
            f"mean pressure, {joint}": found[k] / float(exact[k]) - 1.0
            for k, joint in enumerate(("inner joint", "outer joint"))
        }
