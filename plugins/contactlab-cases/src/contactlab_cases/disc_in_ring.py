"""A full disc in a ring under a pressure that varies around it: smooth, closed, no edge of contact and no support."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.nested import STEEL, around, relative, squeeze
from contactlab_cases.rings import SOURCE, TwoRings
from contactlab_cases.statics import projected, static_job

RADIUS, OUTER, CELLS = 0.6, 1.0, 8  # mm; cells of the disc on a quarter, at level 1
SOFT = 1e-5 * STEEL[0]  # N/mm: springs that hold both bodies in place, also where facets would turn the disc


@dataclass(frozen=True)
class DiscInRing(Case):
    """`ratio` of the ring's cells to the disc's; `wave` of cos 2t; `stiff` modulus of the disc over the ring's."""

    ratio: float = 2.0
    wave: float = 0.1
    stiff: float = 1.0

    title: ClassVar[str] = "a disc in a ring"
    source: ClassVar[str] = SOURCE
    family: ClassVar[str] = "smooth"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"ratio": (0.5, 1.0, 2.0), "wave": (0.0, 0.1), "stiff": (1.0, 10.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run."""
        n = CELLS * setup.level
        around = 4 * round(self.ratio * n)
        meshes = {
            "disc": {"use": "disc", "radius": RADIUS, "cells": [n, max(2, n // 2)]},
            "ring": {"use": "ring", "radii": [RADIUS, OUTER], "cells": [around, max(2, around // 12)]},
        }
        bodies: dict[str, Any] = {name: {"material": name, "mesh": mesh} for name, mesh in meshes.items()}
        contact = {"slave": "disc.arc", "master": "ring.inner", "start": {"gap": "zero"}}
        young, nu = STEEL
        job = static_job(
            "pressed", setup,
            {"disc": {"young": young * self.stiff, "poisson": nu}, "ring": {"young": young, "poisson": nu}},
            bodies, contact,
            loads=[squeeze("ring.outer", 1.0, self.wave)],
            effects=[{"use": "spring", "on": name, "stiffness": [SOFT, SOFT]} for name in meshes],
        )  # fmt: skip
        return (job,)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The pressure that the coarser side carries: h is of its cells."""
        size = max(1.0, 1.0 / self.ratio) ** 2
        why, told = "bilinear cells, 8 of them on a quarter, h^2", ("patch-test",)
        return [
            error("L2 of the carried pressure", 0.012 * size, why, order=2.0, codes=told),
            error("mean pressure", 0.006 * size, "half of that", codes=told),
            reported("L2 of the reported pressure"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form all around."""
        young, nu = STEEL
        mean, wave = TwoRings(0.0, RADIUS, OUTER, (young * self.stiff, nu), STEEL).pressure(1.0, self.wave)
        at = np.linspace(0.0, 2.0 * np.pi, 8001)
        exact, found = mean + wave * np.cos(2.0 * at), around(only(done))(at)
        n = CELLS * setup.level
        carried = projected(at, found, 4 * min(n, round(self.ratio * n)))
        return {
            "L2 of the carried pressure": relative(carried, exact),
            "mean pressure": float(np.mean(carried)) / mean - 1.0,
            "L2 of the reported pressure": relative(found, exact),
        }
