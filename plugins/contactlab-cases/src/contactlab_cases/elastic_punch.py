"""An elastic square punch whose corners press with a power of the distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import graded_count, iterations, ordered, static_job

EXPONENTS = {1.0: -0.2260, 10.0: -0.4443, 100.0: -0.4937, 0.1: -0.0378}
"""p ~ r^e at a frictionless corner of 90 degrees on a half-plane, nu = 0.3, by E of the punch over E of the block."""


@dataclass(frozen=True)
class ElasticPunch(Case):
    """Half width 1, height 4, on a block 20 x 20.

    contrast  of the moduli, punch over block
    ratio     cells of the block under the punch over cells of the punch
    smallest  cells, at the corners of the punch
    """

    contrast: float = 1.0
    ratio: float = 1.5
    smallest: float = 0.001

    title: ClassVar[str] = "elastic square punch, exponent at its corners"
    source: ClassVar[str] = "Dundurs & Lee 1972; Bogy 1971"
    family: ClassVar[str] = "complete contact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"contrast": tuple(EXPONENTS), "ratio": (0.7, 1.5)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"singular pressure", "stiffness contrast"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run; the block has `ratio` times the punch's cells under it, so that nodes do not match."""
        growth, smallest = 1.0 + 0.2 / (1.0 + setup.level), self.smallest / setup.level
        inside, beside = (graded_count(length, smallest, growth) for length in (1.0, 9.0))
        down, up = (graded_count(length, smallest, growth) for length in (20.0, 4.0))
        big = [growth ** (n - 1) for n in (inside, beside, down, up)]
        punch = {
            "use": "rectangle", "x": [-1.0, 0.0, 1.0], "y": [0.0, 4.0],
            "cells": [[inside, inside], up], "grading": [[big[0], 1.0 / big[0]], big[3]],
        }  # fmt: skip
        more = int(self.ratio * inside)
        block = {
            "use": "rectangle", "x": [-10.0, -1.0, 0.0, 1.0, 10.0], "y": [-20.0, 0.0],
            "cells": [[beside, more, more, beside], down],
            "grading": [[1.0 / big[1], big[0], 1.0 / big[0], big[1]], 1.0 / big[2]],
        }  # fmt: skip
        return (
            static_job(
                "pressed", setup,
                {
                    "punch": {"young": 1000.0 * self.contrast, "poisson": 0.3},
                    "block": {"young": 1000.0, "poisson": 0.3},
                },
                {"punch": {"material": "punch", "mesh": punch}, "block": {"material": "block", "mesh": block}},
                {"slave": "punch.bottom", "master": "block.top"},
                supports=[
                    {"on": "block.bottom", "ux": 0.0, "uy": 0.0},
                    {"on": "punch.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -1e-5}},
                ],
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The exponent of the pressure at the corner, judged if an exact one is known."""
        why = "the next term of the series at a fifth of the half-width, and three cells of the singularity"
        known = EXPONENTS.get(self.contrast)
        slope = reported("exponent less the exact one")
        if known is not None:
            answer = Answer(known, origin="frictionless corner of 90 degrees on a half-plane, nu = 0.3")
            slope = error("exponent less the exact one", 0.04, why, answer=answer)
        return slope, reported("exponent"), reported("nodes in the fit"), reported("iterations")

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Slope of log p over log r from three cells to a fifth of the half-width, at the right corner."""
        curve = only(done).curve()
        x, p = ordered(curve.x, curve.pressure)
        inner = np.flatnonzero(x <= 1.0 + 1e-6)
        h, r = float(np.diff(x[inner])[-1]), 1.0 - x
        near = (r > 3.0 * h) & (r < 0.2)
        slope = float(np.polyfit(np.log(r[near]), np.log(p[near]), 1)[0])
        found = {
            "exponent": slope,
            "nodes in the fit": float(np.count_nonzero(near)),
            "iterations": iterations(only(done)),
        }
        known = EXPONENTS.get(self.contrast)
        return found if known is None else {**found, "exponent less the exact one": slope - known}
