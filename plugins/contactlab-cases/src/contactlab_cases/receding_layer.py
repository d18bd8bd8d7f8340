"""A layer on a block, pressed over a short length: contact recedes immediately, to a length independent of the load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.statics import ordered, static_job

YOUNG, LOAD = 70000.0, 2.0  # MPa; pressure over a quarter of the thickness to either side
CELLS = 8  # through the thickness of 1 at level 1


@dataclass(frozen=True)
class RecedingLayer(Case):
    """`stiff` modulus of the layer over the block's; `times` as much load in the second run; `ratio` of cells."""

    stiff: float = 1.0
    times: float = 10.0
    ratio: float = 1.5

    title: ClassVar[str] = "layer on a block, receding contact"
    source: ClassVar[str] = "Keer, Dundurs & Tsai 1972; Dundurs 1975: receding contact does not depend on the load"
    family: ClassVar[str] = "edges"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"stiff": (0.2, 1.0, 5.0), "ratio": (1.0, 1.5)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure", "partial contact"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Two loads, and a mesh of other cells for the length itself."""
        return [
            self._job("loaded", setup, 1.0, 1.0),
            self._job("more", setup, self.times, 1.0),
            self._job("finer", setup, 1.0, 1.75),
        ]

    def _job(self, name: str, setup: Setup, load: float, finer: float) -> Job:
        n = 4 * round(0.25 * CELLS * setup.level * finer)
        meshes = {
            "layer": {"x": [0.0, 0.25, 3.0, 6.0], "y": [0.0, 1.0], "cells": [[n // 4, 11 * n // 4, n], n]},
            "block": {
                "x": [0.0, 3.0, 8.0], "y": [-8.0, 0.0], "cells": [[round(3 * n * self.ratio), n], 2 * n],
                "grading": [[1.0, 6.0], 0.05],
            },
        }  # fmt: skip
        bodies = {
            body: {"material": body, "mesh": {"use": "rectangle"} | mesh, "sets": {}} for body, mesh in meshes.items()
        }
        bodies["layer"]["sets"] = {"pressed": {"of": "top", "x": [0.0, 0.25]}}
        return static_job(
            name, setup,
            {"layer": {"young": YOUNG * self.stiff, "poisson": 0.3}, "block": {"young": YOUNG, "poisson": 0.3}},
            bodies, {"slave": "layer.bottom", "master": "block.top"},
            supports=[
                {"on": "block.bottom", "ux": 0.0, "uy": 0.0}, {"on": "layer.left", "ux": 0.0},
                {"on": "block.left", "ux": 0.0},
            ],
            loads=[{"on": "layer.pressed", "pressure": {"ramp": "linear", "to": LOAD * load}, "follower": False}],
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Compare with linear elasticity of receding contact, and the length between two meshes."""
        return [
            at_most("nodes that the load closes or opens", 0.0, "the extent of contact does not depend on the load"),
            error(
                "pressure over the load, largest difference",
                2e-3,
                "proportional but for strains of 1e-4 to 1e-3",
                codes=("kept-overlap",),
            ),
            error("length against the other mesh in cells", 1.5, "nodes show it to a cell of either mesh"),
            error("resultant over the load, less one", 1e-6, "equilibrium"),
            reported("half-length over the thickness"),
            reported("largest pressure over the load"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare pressures, and the ends of contact at x > 0."""
        curves = {name: record.curve() for name, record in done.items()}
        one, more = curves["loaded"], curves["more"]
        ends = {}
        for name, curve in curves.items():
            x, force = ordered(curve.x, curve.nodal_pressure)
            last = int(np.flatnonzero(force > 1e-9)[-1])
            ends[name] = 0.5 * float(x[last] + x[last + 1])
        change = np.abs(more.pressure / self.times - one.pressure).max() / one.pressure.max()
        return {
            "nodes that the load closes or opens": float(
                np.count_nonzero((one.nodal_pressure > 0.0) != (more.nodal_pressure > 0.0))
            ),
            "pressure over the load, largest difference": float(change),
            "length against the other mesh in cells": (ends["loaded"] - ends["finer"]) * CELLS * setup.level,
            "resultant over the load, less one": float(done["loaded"].reaction("block.bottom")[1]) / (0.25 * LOAD)
            - 1.0,
            "half-length over the thickness": ends["finer"],
            "largest pressure over the load": float(one.pressure.max()) / LOAD,
        }
