"""Two squares that fall corner on corner."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, invariant
from contactlab_cases.dynamics import WORK, momentum_change
from contactlab_cases.series import series, table

END, SPEED, MASS = 1e-4, 5000.0, 2.7e-9 * 100.0


@dataclass(frozen=True)
class VertexToVertex(Case):
    """`offset` of the corners in segments: an aligned pair stays its own mirror image, an offset pair mirrors the
    pair with the opposite offset."""

    offset: float = 0.0
    cells: int = 10

    title: ClassVar[str] = "vertex to vertex"
    source: ClassVar[str] = "mirror symmetry; Wriggers 2006, 9"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"offset": (0.0, 0.1, 0.3), "cells": (6, 10)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"symmetry", "momentum", "corners"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job if corners are aligned, else one for each sign of the offset."""
        ways = (1.0, -1.0) if self.offset else (1.0,)
        return tuple(self._job(setup, way * self.offset, "right" if way > 0.0 else "left") for way in ways)

    def _job(self, setup: Setup, offset: float, name: str) -> Job:
        cells = self.cells * setup.level
        segment = 10.0 / cells
        changes = {
            **setup.changes("upper", "lower"),
            "bodies.upper.mesh.cells": [cells, cells], "bodies.lower.mesh.cells": [cells, cells],
            # both move by half, so that one fall is the mirror image of the other
            "bodies.upper.shift": [0.5 * offset * segment, 0.05], "bodies.lower.shift": [-0.5 * offset * segment, 0.0],
            "time.end": END,
        }  # fmt: skip
        momenta = series("momentum.x", "momentum.y", "velocity.upper.x")
        overlap = {"use": "overlap-area", "reach": 2.0 * segment}
        return Job(name, "vertex-to-vertex", changes, (momenta, overlap), work=WORK, fields=True)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Mirror symmetry and momentum, which must hold to round-off, and the overlap."""
        why = "the scene is symmetric: round-off, grown by the instability of corners"
        return (
            at_most("mirror symmetry, largest error in segments", 1e-8, why, "h"),
            at_most("overlap in segments squared", 0.01, "a hundredth of a cell", "h2"),
            invariant("linear momentum, change", 1e-12, "forces come in pairs"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare the fall with its own mirror image, or with the fall of opposite offset."""
        segment = 10.0 / (self.cells * setup.level)
        first = done["right"]
        other = done.get("left", first)
        return {
            "mirror symmetry, largest error in segments": mirrored(first, other) / segment,
            "overlap in segments squared": max(float(r.watched["overlap-area"]["largest"][0]) for r in (first, other))
            / segment**2,
            "linear momentum, change": max(momentum_change(table(r), 2.0 * MASS * SPEED) for r in (first, other)),
        }


def mirrored(first: Record, second: Record) -> float:
    """Largest difference [mm] of positions to the mirror image of another run about x = 0."""
    image = second.nodes * [-1.0, 1.0]
    twin = [int(np.argmin(np.hypot(*(image - x).T))) for x in first.nodes]
    here, there = (record.nodes + record.displacement for record in (first, second))
    return float(np.abs(here - there[twin] * [-1.0, 1.0]).max())
