"""A ring that is pressed onto another and turned by a shear on its outside: torque, twist and traction are exact.

No moment is lost on the way: the shear between the rings is the outside's times (c/b)^2, and nothing slips where
it is below mu p.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.nested import STEEL, around
from contactlab_cases.rings import SOURCE, stood_ring_pressure
from contactlab_cases.statics import projected, static_job

RADII = (0.3, 0.6, 1.0)  # mm
CELLS = 12  # of the inner ring on a quarter, at level 1


@dataclass(frozen=True)
class TorsionFit(Case):
    """A pressure of 1 MPa and a shear on the outside; the hole of the inner ring is held.

    load   shear between the rings over mu times the pressure there: all of it slips from 1 on
    ratio  cells of the outer ring's hole over cells of the inner ring's edge
    mu     of Coulomb's law
    """

    load: float = 0.8
    ratio: float = 2.0
    mu: float = 0.3

    title: ClassVar[str] = "a ring pressed onto another and turned"
    source: ClassVar[str] = f"{SOURCE}; Coulomb 1784: torsion"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "load": (0.2, 0.8, 0.95), "ratio": (0.5, 1.0, 2.0), "mu": (0.1, 0.3, 1.0)
    }  # fmt: skip
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure", "friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def _exact(self) -> tuple[float, float]:
        """Pressure and shear [MPa] between the rings."""
        pressure = stood_ring_pressure(*RADII, STEEL)
        return pressure, self.load * self.mu * pressure

    def _cells(self, setup: Setup) -> tuple[int, int]:
        """Cells of the inner and of the outer ring along the quarter."""
        n = CELLS * setup.level
        return n, max(1, round(self.ratio * n))

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: pressed first, then turned."""
        a, b, c = RADII
        rings = {"inner": ([a, b], self._cells(setup)[0]), "outer": ([b, c], self._cells(setup)[1])}
        bodies: dict[str, Any] = {
            name: {"material": "steel", "mesh": {"use": "ring", "radii": radii, "cells": [4 * n, max(3, n // 3)]}}
            for name, (radii, n) in rings.items()
        }
        contact = {
            "slave": "inner.outer", "master": "outer.inner", "start": {"gap": "zero"},
            "friction": {"use": "coulomb", "mu": self.mu},
        }  # fmt: skip
        shear = self._exact()[1] * (b / c) ** 2
        job = static_job(
            "turned", setup, {"steel": {"young": STEEL[0], "poisson": STEEL[1]}}, bodies, contact,
            supports=[{"on": "inner.inner", "ux": 0.0, "uy": 0.0}], time={"end": 2.0}, steps=2, fields=True,
            loads=[
                {"on": "outer.outer", "pressure": {"ramp": "linear", "to": 1.0, "duration": 1.0}},
                {"on": "outer.outer", "shear": {"ramp": "linear", "to": shear, "begin": 1.0, "duration": 1.0}},
            ],
        )  # fmt: skip
        return (job,)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Compare what the coarser side carries; the twist is as for both rings joined."""
        n = min(self._cells(setup))
        why = f"bilinear rings of {n} cells a quarter, h^2"
        size = (12.0 / n) ** 2
        return [
            error("L2 of the carried pressure", 0.01 * size, why),
            error("L2 of the carried shear", 0.01 * size, why),
            error("mean shear", 0.005 * size, f"the torque is carried whole; {why}"),
            error("twist of the outside", 0.02 * size, why),
            reported("share of closed nodes that slip"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form all around."""
        record, coarse = only(done), 4 * min(self._cells(setup))
        at = np.linspace(0.0, 2.0 * np.pi, 24 * coarse + 1)
        found = {
            column: projected(at, np.abs(around(record, column)(at)), coarse) / exact - 1.0
            for column, exact in zip(("pressure", "shear"), self._exact(), strict=True)
        }
        return {
            "L2 of the carried pressure": float(np.sqrt(np.mean(found["pressure"] ** 2))),
            "L2 of the carried shear": float(np.sqrt(np.mean(found["shear"] ** 2))),
            "mean shear": float(np.mean(found["shear"])),
            "twist of the outside": self._twist(record) / self._exact_twist() - 1.0,
            "share of closed nodes that slip": float(np.mean(np.asarray(record.curve().state) == 2)),
        }

    def _exact_twist(self) -> float:
        """Angle [rad] of the outside against the hole: r d(u/r)/dr = q b^2/(G r^2)."""
        a, b, c = RADII
        modulus = STEEL[0] / (2.0 * (1.0 + STEEL[1]))
        return self._exact()[1] * b**2 / (2.0 * modulus) * (1.0 / a**2 - 1.0 / c**2)

    @staticmethod
    def _twist(record: Record) -> float:
        x = record.nodes
        outside = np.isclose(np.hypot(*x.T), RADII[2], rtol=1e-6)
        turn = x[outside, 0] * record.displacement[outside, 1] - x[outside, 1] * record.displacement[outside, 0]
        return float(np.abs(np.mean(turn))) / RADII[2] ** 2
