"""Taylor's bar: copper against a rigid wall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Floats, Ints, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import only
from contactlab_cases.dynamics import WORK

HEIGHT, WIDTH, DENSITY = 32.4, 3.2, 8.93e-9


@dataclass(frozen=True)
class TaylorBar(Case):
    """A bar of 32.4 x 3.2 in plane strain that hits a wall, `cells` across, with `speed` [mm/s]."""

    cells: int = 3
    speed: float = 227000.0

    title: ClassVar[str] = "bar of Taylor"
    source: ClassVar[str] = "Taylor 1948; momentum and incompressible flow"
    family: ClassVar[str] = "large deformation"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"cells": (3, 4), "speed": (113500.0, 150000.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1-fbar", "q1-reduced")
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "large deformation", "plasticity"})
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: the first 80 microseconds of the impact."""
        cells = self.cells * setup.level
        law = {
            "use": "linear-hardening", "young": 117000.0, "poisson": 0.35, "density": DENSITY,
            "yield_stress": 400.0, "hardening": 100.0,
        }  # fmt: skip
        mesh = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, HEIGHT], "cells": [cells, 10 * cells]}
        scene = {
            "name": "taylor-bar", "time": {"end": 80e-6}, "integrator": setup.integrator, "materials": {"copper": law},
            "bodies": {
                "bar": {"element": setup.element, "material": "copper", "mesh": mesh, "velocity": [0.0, -self.speed]}
            },
            "rigid": {"wall": {"line": [[20.0, 0.0], [-5.0, 0.0]]}},
            "contacts": [{"slave": "bar.bottom", "master": "wall", "algorithm": setup.algorithm}],
            "supports": [{"on": "bar.left", "ux": 0.0}],
        }  # fmt: skip
        return (Job("hit", scene, work=WORK, fields=True),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Plastic flow keeps the area; what it takes is the kinetic energy."""
        kinetic = Answer(self._kinetic, origin="m v^2/2")
        return (
            at_most("change of the area", 0.01, "elastic strains of a yield stress over the bulk modulus"),
            error("energy taken by flow over the kinetic one, less one", 0.05, "what is left vibrates", answer=kinetic),
            reported("width at the wall", "mm"),
            reported("length in the end", "mm"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures from the deformed shape."""
        record = only(done)
        x, cells = record.nodes + record.displacement, record.cells["bar"]
        top = np.isclose(record.nodes[:, 1], HEIGHT) & np.isin(np.arange(len(x)), cells)
        own = np.unique(cells)
        taken = float(record.summary["balance"]["plastic"])
        return {
            "change of the area": abs(area(x, cells) / area(record.nodes, cells) - 1.0),
            "energy taken by flow over the kinetic one, less one": taken / self._kinetic - 1.0,
            "width at the wall": float(x[own, 0].max()),
            "length in the end": float(x[top, 1].mean() - x[own, 1].min()),
        }

    @property
    def _kinetic(self) -> float:
        """Energy [mJ/mm] before the impact."""
        return 0.5 * DENSITY * HEIGHT * WIDTH * self.speed**2


def area(nodes: Floats, cells: Ints) -> float:
    """Area [mm2] of quadrilaterals, by their diagonals."""
    a, b, c, d = (nodes[cells[:, i]] for i in range(4))
    p, q = c - a, d - b
    return float(0.5 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())
