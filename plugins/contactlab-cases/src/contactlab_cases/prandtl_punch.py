"""Prandtl's punch: the force at which a plastic half plane flows, and elements that lock above it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported, within
from contactlab_cases.circles import only
from contactlab_cases.statics import graded_count, static_job

YIELD, OUTER, GROWTH = 1.0, 10.0, 1.3  # MPa; width and depth of the block in half-widths of the punch: 5 would split
LIMIT = (2.0 + math.pi) / math.sqrt(3.0)  # mean pressure over the yield stress


@dataclass(frozen=True)
class PrandtlPunch(Case):
    """A half of the punch, of half-width 1 mm, on a block without hardening.

    cells      in a fifth of the half-width at the edge, from which they grow
    stiffness  modulus over the yield stress; softer soil is pushed deeper until it flows, and where that is a fifth
               of the half-width it resists by 4 % more than the limit of small displacements
    """

    cells: int = 4
    stiffness: float = 1000.0

    title: ClassVar[str] = "Prandtl's punch on a plastic half plane"
    source: ClassVar[str] = "Prandtl 1920; Hill 1950, The Mathematical Theory of Plasticity"
    family: ClassVar[str] = "plastic"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"cells": (4, 6, 8), "stiffness": (1000.0, 3000.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"plasticity"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1-fbar", "q2", "q1")

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Pushed in until the force has long stopped rising, which takes sixty yield strains of a half-width."""
        edge, growth = self._edge(setup)
        under, out, down = (graded_count(length, edge, growth) for length in (1.0, OUTER - 1.0, OUTER))
        mesh = {
            "use": "rectangle", "x": [0.0, 1.0, OUTER], "y": [-OUTER, 0.0], "cells": [[under, out], down],
            "grading": [[growth ** -(under - 1), growth ** (out - 1)], growth ** -(down - 1)],
        }  # fmt: skip
        law = {
            "use": "linear-hardening", "young": self.stiffness * YIELD, "poisson": 0.3, "yield_stress": YIELD,
            "hardening": 0.0,
        }  # fmt: skip
        push = 60.0 / self.stiffness
        across = {"x": [0.0, 1.0], "y": [0.0, 0.5]}
        punch = {"use": "rectangle", **across, "cells": [under, 2], "grading": [growth ** -(under - 1), 1.0]}
        stiff = {"young": 1e3 * self.stiffness * YIELD, "poisson": 0.0}
        return (
            static_job(
                "pushed", setup, {"soil": law, "stiff": stiff},
                {"block": {"material": "soil", "mesh": mesh}, "punch": {"material": "stiff", "mesh": punch}},
                {"slave": "punch.bottom", "master": "block.top"}, steps=8, frames=8,
                supports=[
                    {"on": "block.bottom", "ux": 0.0, "uy": 0.0}, {"on": "block.left", "ux": 0.0},
                    {"on": "punch.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -push}},
                ],
            ),
        )  # fmt: skip

    def _edge(self, setup: Setup) -> tuple[float, float]:
        """Size of the cells next to the edge [mm] and their growth; quadratic ones have a node in the middle."""
        size, growth = 0.2 / self.cells / setup.level, GROWTH
        return (2.0 * size, growth**2) if setup.element == "q2" else (size, growth)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """A cell next to the edge carries as much as a punch wider by half of the cell."""
        answer = Answer(LIMIT, origin=self.source)
        told = ("locking",)
        if setup.element == "q1":
            most = within("mean pressure over the limit, less one", -0.02, 0.02, "nothing locks", codes=told)
        else:
            why = "no locking; the edge node carries for half a cell next to the punch, which is counted to the punch"
            most = error("mean pressure over the limit, less one", 0.02, why, answer=answer, codes=told)
        flat = "perfect plasticity: what is far away still gives a little; an element that locks rises by 5 %"
        return (
            most,
            within("rise of the force in the last quarter", -0.01, 0.035, flat, codes=told),
            reported("mean pressure over the yield stress"),
            reported("iterations"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate the reaction; the contact reaches half a segment beyond the last node that is pressed."""
        record = only(done)
        force = record.history["block.bottom.fy"]
        # the cell next to the edge flows with it, in the mean over half its width
        pressure = abs(float(force[-1])) / (1.0 + 0.5 * self._edge(setup)[0])
        return {
            "mean pressure over the limit, less one": pressure / (LIMIT * YIELD) - 1.0,
            "rise of the force in the last quarter": float(force[-1] / force[-3]) - 1.0,
            "mean pressure over the yield stress": pressure / YIELD,
            "iterations": float(record.summary["iterations"]),
        }
