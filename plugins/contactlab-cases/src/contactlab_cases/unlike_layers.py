"""Two layers of unlike materials that slide on each other: with Coulomb friction, short waves grow without limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, no_limit, reported
from contactlab_cases.driven_layers import CELLS, DRIVEN, WAVE_NUMBER, exact_wave, layers_job
from contactlab_cases.interface_waves import growth_and_speed, short_growth, sliding_wave, tapered
from contactlab_cases.series import table

MESHES = {"whole": 1, "halved": 2}


@dataclass(frozen=True)
class UnlikeLayers(Case):
    """`mu`; `modulus` of the lower layer over the upper one's, at one density and nu = 0.

    A wave that is driven grows as half planes say, on either mesh. What grows fastest is made of single cells, so that
    its rate doubles as they are halved: there is nothing to converge to.
    """

    mu: float = 0.9
    modulus: float = 1.44

    title: ClassVar[str] = "sliding layers of unlike materials"
    source: ClassVar[str] = "Ranjith & Rice 2001; Adams 1995: Coulomb sliding where generalised Rayleigh waves exist"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.0, 0.6, 0.9), "modulus": (1.21, 1.44)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "waves"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The same waves on a mesh and on one twice as fine."""
        return [
            layers_job(name, setup, n * CELLS * setup.level, self.modulus, self.mu)
            for name, n in MESHES.items()
            if name not in done
        ]

    def ill_posed(self, setup: Setup) -> str:
        """Return a reason for any friction: these materials have a generalised Rayleigh wave."""
        return "the shorter a wave, the faster it grows" if self.mu > 0.0 else ""

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Require errors of second order in the cells of a wave; without friction nothing may grow."""
        why = "ten cells a wave on the coarser mesh: 0.8 % of its speed"
        bounds = [
            error(f"{what} of the driven wave, cells {name}", most / (n * setup.level) ** 2, why, order=2.0)
            for name, n in MESHES.items()
            for what, most in (("growth", 0.016), ("speed", 0.02))
        ]
        if not self.ill_posed(setup):
            why = "without friction waves keep their energy"
            return [*bounds, at_most("growth of what is made of cells, cells halved", 0.1, why, "1/s")]
        why = "what grows fastest is made of cells; waves of other lengths are still among it after five of its times"
        return [
            *bounds,
            no_limit("growth of what is made of cells, cells halved over whole", 1.7, 2.3, why),
            reported("growth of the free wave over k c"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate waves once nothing drives them; growth and speed are over k c, less the values of half planes."""
        found: dict[str, float] = {}
        cells = {}
        for name, record in done.items():
            seen = table(record, "nodal-forces")
            late = seen["time"] > 1.1 * DRIVEN
            x, times = seen["x"], seen["time"][late]
            rows = (seen["force"] - seen["force"][0])[late] * tapered(x, 0.5)
            wave, exact = rows @ np.exp(-1j * WAVE_NUMBER * x), exact_wave(times, self.modulus, self.mu)
            growth, speed = (
                a - b for a, b in zip(*(growth_and_speed(WAVE_NUMBER * times, w) for w in (wave, exact)), strict=True)
            )
            found[f"growth of the driven wave, cells {name}"] = growth
            found[f"speed of the driven wave, cells {name}"] = speed
            cells[name] = short_growth(times, rows, x)
        if not self.ill_posed(setup):
            return found | {"growth of what is made of cells, cells halved": cells["halved"]}
        return found | {
            "growth of what is made of cells, cells halved over whole": cells["halved"] / cells["whole"],
            "growth of the free wave over k c": sliding_wave(self.modulus, self.mu).real,
        }
