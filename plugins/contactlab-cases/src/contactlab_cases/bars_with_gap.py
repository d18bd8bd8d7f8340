"""Two bars with a gap: a load closes it, both bars share what is more, and it opens again as the load goes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error
from contactlab_cases.circles import only
from contactlab_cases.dynamics import strip
from contactlab_cases.statics import static_job

LENGTH, HEIGHT, YOUNG, STRAIN = 10.0, 2.0, 1000.0, 1e-4  # mm, MPa; the gap over the length of a bar


@dataclass(frozen=True)
class BarsWithGap(Case):
    """`load` over what closes the gap; `stiff` modulus of the second bar over the first's; `ratio` of its cells."""

    load: float = 3.0
    stiff: float = 4.0
    ratio: float = 1.5

    title: ClassVar[str] = "bars whose gap closes and opens"
    source: ClassVar[str] = "Timoshenko, Strength of Materials I: statically indeterminate bars"
    family: ClassVar[str] = "patch"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "load": (0.5, 3.0, 30.0), "stiff": (0.1, 4.0, 1000.0), "ratio": (0.5, 1.5)
    }  # fmt: skip
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"release", "pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2")

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Loaded at the gap's edge until t = 1, unloaded until t = 2."""
        gap, n = STRAIN * LENGTH, 4 * setup.level
        pull = {"ramp": "table", "to": self.load * YOUNG * STRAIN, "points": [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]}
        second = strip((LENGTH + gap, 2.0 * LENGTH + gap), (0.0, HEIGHT), [n, max(1, round(self.ratio * n))])
        return (
            static_job(
                "loaded", setup,
                {"m": {"young": YOUNG, "poisson": 0.0}, "second": {"young": YOUNG * self.stiff, "poisson": 0.0}},
                {"first": strip((0.0, LENGTH), (0.0, HEIGHT), [n, n]), "other": second | {"material": "second"}},
                {"slave": "first.right", "master": "other.left"}, steps=4, frames=2, time={"end": 2.0}, fields=True,
                supports=[
                    {"on": "first.left", "ux": 0.0, "uy": 0.0}, {"on": "other.right", "ux": 0.0, "uy": 0.0},
                ],
                loads=[{"on": "first.right", "tx": pull}],
            ),
        )  # fmt: skip

    def exact(self) -> float:
        """Stress [MPa] of the second bar under the full load q: k1 u + k2 (u - g) = q."""
        return max(0.0, self.load - 1.0) * YOUNG * STRAIN * self.stiff / (1.0 + self.stiff)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bars that do not bulge, whatever the meshes."""
        why = "a uniform stress is in the space of every element: Newton's tolerance"
        return (
            error("stress of the second bar over that of the load", 1e-8, why, codes=("early-contact",)),
            error("stress of the first bar over that of the load", 1e-8, why, codes=("early-contact",)),
            at_most("stress left after unloading over that of the load", 1e-9, "nothing touches: Newton's tolerance"),
            at_most("way left after unloading over the gap", 1e-6, "elastic: Newton's tolerance"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate the reactions of both ends."""
        record = only(done)
        load = self.load * YOUNG * STRAIN
        first, second = (-np.asarray(record.history[f"{on}.fx"]) / HEIGHT for on in ("first.left", "other.right"))
        loaded = int(np.argmin(np.abs(np.asarray(record.history["time"]) - 1.0)))
        return {
            "stress of the second bar over that of the load": (float(second[loaded]) - self.exact()) / load,
            "stress of the first bar over that of the load": (float(first[loaded]) - load + self.exact()) / load,
            "stress left after unloading over that of the load": float(max(abs(first[-1]), abs(second[-1]))) / load,
            "way left after unloading over the gap": float(np.abs(record.displacement).max()) / (STRAIN * LENGTH),
        }
