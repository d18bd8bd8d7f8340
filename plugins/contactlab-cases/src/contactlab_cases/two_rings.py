"""Two rings pressed together by a pressure that varies around them: no edge of contact, an exact answer, an order.

With the finer side as slave, multipliers follow the kinks that the coarser side's displacements have at its nodes: what
they report alternates within each coarse segment and falls with h alone. The pressure that the coarser side carries,
the L2 projection of the multipliers onto its trace, has none of that and falls with h^2 whichever side is slave.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported, within
from contactlab_cases.rings import SOURCE, TwoRings
from contactlab_cases.statics import ordered, projected, static_job

RADII = (0.2, 0.6, 1.0)  # mm
STEEL = (70000.0, 0.3)
CELLS = 6  # of the coarser ring on a quarter, at level 1
SIZES = {"coarse": 4, "fine": 8}


@dataclass(frozen=True)
class RingsPressed(Case):
    """Pressure between two rings.

    ratio  cells along the outer ring's inner edge over cells along the inner ring's outer edge
    wave   amplitude of cos 2t in the outer pressure, over its mean
    stiff  modulus of the inner ring over the outer ring's
    mean   outer pressure [MPa]: strains of 1e-5, so that geometry adds as little
    """

    ratio: float = 2.0
    wave: float = 0.1
    stiff: float = 1.0
    mean: float = 1.0

    title: ClassVar[str] = "two rings pressed together"
    source: ClassVar[str] = SOURCE
    family: ClassVar[str] = "smooth"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"ratio": (0.5, 2.0, 5.0), "wave": (0.0, 0.1), "stiff": (1.0, 10.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure", "order"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Two meshes, one twice as fine."""
        return [self.job(name, setup, CELLS * size * setup.level) for name, size in SIZES.items() if name not in done]

    def _cells(self, n: int) -> tuple[int, int]:
        """Cells of the inner and of the outer ring along the quarter, `n` of the coarser one."""
        return (n, round(n * self.ratio)) if self.ratio >= 1.0 else (round(n / self.ratio), n)

    def job(self, name: str, setup: Setup, cells: int) -> Job:
        """A run with so many cells on the quarter of the coarser ring."""
        a, b, c = RADII
        along = self._cells(cells)
        meshes = [
            {"use": "ring", "radii": radii, "angles": [0.0, 90.0], "cells": [count, max(2, count // 3)]}
            for radii, count in zip(([a, b], [b, c]), along, strict=True)
        ]
        (young, poisson), bodies = STEEL, ("inner", "outer")
        moduli = (young * self.stiff, young)
        return static_job(
            name, setup,
            {body: {"young": modulus, "poisson": poisson} for body, modulus in zip(bodies, moduli, strict=True)},
            {body: {"material": body, "mesh": mesh} for body, mesh in zip(bodies, meshes, strict=True)},
            {"slave": "inner.outer", "master": "outer.inner", "start": {"gap": "zero"}},
            supports=[
                {"on": f"{body}.{end}", axis: 0.0} for body in bodies for end, axis in (("start", "uy"), ("end", "ux"))
            ],
            loads=[
                {
                    "on": "outer.outer", "pressure": {"ramp": "linear", "to": self.mean},
                    "profile": {"by": "angle", "cosine": [1.0, self.wave, 180.0]},
                }
            ],
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The error on the finer mesh, and how fast it falls."""
        return [
            error(
                "L2 of the carried pressure",
                0.001,
                "second order: 1e-4 on 48 cells a quarter, and geometry adds 1e-5",
                order=2.0,
                codes=("patch-test",),
            ),
            within("order of the carried pressure", 1.8, 2.6, "two of bilinear elements; coarse meshes are beyond it"),
            at_most("mean pressure, error", 0.002, "half of the error in L2 if all nodes are in error"),
            reported("L2 of the reported pressure"),
            reported("order of the reported pressure"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form over the quarter."""
        carried, told, means = {}, {}, {}
        for name, record in done.items():
            carried[name], told[name], means[name] = self.errors(record, CELLS * SIZES[name] * setup.level)
        return {
            "L2 of the carried pressure": carried["fine"],
            "order of the carried pressure": float(np.log2(carried["coarse"] / carried["fine"])),
            "mean pressure, error": abs(means["fine"]),
            "L2 of the reported pressure": told["fine"],
            "order of the reported pressure": float(np.log2(told["coarse"] / told["fine"])),
        }

    def errors(self, record: Record, coarser: int) -> tuple[float, float, float]:
        """Relative errors in L2 of the carried and of the reported pressure, and of the mean; `coarser`: its cells."""
        curve = record.curve()
        angle, pressure = ordered(np.arctan2(curve.y, curve.x), curve.pressure)
        (young, poisson) = STEEL
        rings = TwoRings(*RADII, (young * self.stiff, poisson), STEEL)
        mean, wave = rings.pressure(self.mean, self.mean * self.wave)
        # points lie evenly in the cells of both sides: sums then see nothing of what alternates from node to node
        in_one = 48 * max(1, round(max(self.ratio, 1.0 / self.ratio)))
        at = np.linspace(0.0, 0.5 * np.pi, in_one * coarser + 1)
        exact, found = mean + wave * np.cos(2.0 * at), np.interp(at, angle, pressure)
        off = projected(at, found, coarser) - exact
        return _norm(off) / _norm(exact), _norm(found - exact) / _norm(exact), float(off.mean()) / mean


def _norm(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
