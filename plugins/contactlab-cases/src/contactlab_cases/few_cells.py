"""Confined blocks under their own weight, of one element each or a few: the pressure between them is their weight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.even_compression import EvenCompression
from contactlab_cases.statics import iterations, static_job

YOUNG, HEAVY = 1000.0, 1e-3  # MPa; MPa of load on the top


@dataclass(frozen=True)
class FewCells(Case):
    """`upper` and `lower` elements along the interface, one through each height; `stiff` upper over lower modulus.

    Sides are held, so that strains are of one direction: p everywhere, and the top comes down by p (1 + 1/stiff) H/M.
    """

    upper: int = 1
    lower: int = 1
    stiff: float = 10.0

    title: ClassVar[str] = "blocks of one element a side"
    source: ClassVar[str] = "compression of a confined layer"
    family: ClassVar[str] = "patch"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"upper": (1, 3), "lower": (1, 7), "stiff": (1.0, 10.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"patch test"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2-lagrange", "q1-fbar")

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run."""
        rows = {"upper": ([0.0, 1.0], self.upper), "lower": ([-1.0, 0.0], self.lower)}
        bodies = {
            name: {
                "material": name,
                "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": y, "cells": [n * setup.level, 1]},
            }
            for name, (y, n) in rows.items()
        }
        held = [{"on": f"{name}.{side}", "ux": 0.0} for name in bodies for side in ("left", "right")]
        return (
            static_job(
                "pressed", setup,
                {"upper": {"young": YOUNG * self.stiff, "poisson": 0.3}, "lower": {"young": YOUNG, "poisson": 0.3}},
                bodies, {"slave": "upper.bottom", "master": "lower.top"},
                supports=[*held, {"on": "lower.bottom", "uy": 0.0}],
                loads=[{"on": "upper.top", "pressure": {"ramp": "linear", "to": HEAVY}, "follower": False}],
                fields=True,
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Compare with a uniform strain in each block."""
        why = "the strain is in the space of every element; strains themselves are 1e-6"
        told = ("kept-overlap", "patch-test")
        return [
            error("pressure, largest difference", 1e-5, why, answer=self._answer(setup), codes=told),
            error("way of the top", 1e-5, why, codes=told),
            reported("iterations"),
        ]

    def _answer(self, setup: Setup) -> Answer:
        """The exact pressure of the scene."""
        reference, (job,) = EvenCompression(), self.plan(setup, {})
        assert not isinstance(job.scene, str)
        return Answer(float(reference.solution(job.scene).pressure[0]), origin=reference.origin)

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with M = E (1 - nu)/((1 + nu)(1 - 2 nu))."""
        record, modulus, pressure = only(done), YOUNG * 0.7 / (1.3 * 0.4), self._answer(setup).value
        top = np.isclose(record.nodes[:, 1], 1.0)
        way = HEAVY / modulus * (1.0 + 1.0 / self.stiff)
        return {
            "pressure, largest difference": float(np.abs(record.curve().pressure / pressure - 1.0).max()),
            "way of the top": float(np.abs(record.displacement[top, 1] / way + 1.0).max()),
            "iterations": iterations(record),
        }
