"""A ring shrunk onto another: Lame's pressure from the interference alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import static_job

RADII = (0.2, 0.6, 1.0)  # mm
POISSON = 0.3
YOUNG = 70000.0
CELLS = 36  # of the coarser ring on a quarter, at level 1


@dataclass(frozen=True)
class ShrinkFit(Case):
    """Pressure of an interference.

    interference  of the radii, over the radius
    ratio         cells along the outer ring's inner edge over cells along the inner ring's outer edge
    stiff         modulus of the inner ring over the outer ring's
    """

    interference: float = 1e-3
    ratio: float = 1.0
    stiff: float = 1.0

    title: ClassVar[str] = "a ring shrunk onto another"
    source: ClassVar[str] = "Lame 1852; Timoshenko & Goodier, Theory of Elasticity, 28"
    family: ClassVar[str] = "smooth"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"ratio": (1.0, 1.5), "stiff": (0.1, 1.0, 10.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure", "overlap"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run that pushes the overlap out."""
        (a, b, c), n = RADII, CELLS * setup.level
        radii = {"inner": [a, b * (1.0 + self.interference)], "outer": [b, c]}
        counts = {"inner": n, "outer": round(n * self.ratio)}
        moduli = {"inner": YOUNG * self.stiff, "outer": YOUNG}
        mesh = {"use": "ring", "angles": [0.0, 90.0]}
        bodies = {
            name: {
                "material": name,
                "mesh": {**mesh, "radii": radii[name], "cells": [counts[name], 8 * setup.level]},
            }
            for name in radii
        }
        return [static_job(
            "fitted", setup, {name: {"young": young, "poisson": POISSON} for name, young in moduli.items()}, bodies,
            {"slave": "inner.outer", "master": "outer.inner", "start": {"overlap": "ramp"}},
            supports=[
                {"on": f"{body}.{end}", axis: 0.0} for body in bodies for end, axis in (("start", "uy"), ("end", "ux"))
            ],
        )]  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The mean of the pressure, and how far nodes differ from it."""
        why = "strains of 0.1 %, bilinear rings of 8 cells; with matching meshes facets fit, else runs must warn"
        codes = ("coarse-facets", "pressure-saw")
        return [
            error("mean pressure", 0.01, why, codes=codes),
            error(
                "largest difference of a node from the mean",
                0.03,
                f"nodes alternate with the facets; {why}",
                codes=codes,
            ),
            reported("pressure", "MPa"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with p = delta / (b (inner + outer compliance))."""
        curve = only(done).curve()
        mean = float(np.mean(curve.pressure))
        return {
            "mean pressure": mean / self.exact() - 1.0,
            "largest difference of a node from the mean": float(np.abs(curve.pressure / mean - 1.0).max()),
            "pressure": mean,
        }

    def exact(self) -> float:
        """Lame's pressure [MPa] in plane strain: each ring as with the moduli E/(1 - nu^2) and nu/(1 - nu)."""
        a, b, c = RADII
        nu = POISSON / (1.0 - POISSON)
        outer, inner = YOUNG / (1.0 - POISSON**2), YOUNG * self.stiff / (1.0 - POISSON**2)
        compliance = ((c**2 + b**2) / (c**2 - b**2) + nu) / outer + ((b**2 + a**2) / (b**2 - a**2) - nu) / inner
        return self.interference / compliance
