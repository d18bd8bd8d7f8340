"""The patch test of whole runs: two blocks of nu = 0 on top of each other, in uniform stress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import iterations, static_job

YOUNG, DEPTH = 1e6, 0.01


@dataclass(frozen=True)
class Patch(Case):
    """`upper` segments over `lower` ones, three layers of cells each; all of it turned by `turn` degrees."""

    upper: int = 4
    lower: int = 7
    turn: float = 0.0

    title: ClassVar[str] = "patch test"
    source: ClassVar[str] = "Taylor & Papadopoulos 1991; Crisfield 2000"
    family: ClassVar[str] = "patch"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "upper": (1, 3, 4, 10), "lower": (5, 7, 10), "turn": (0.0, 30.0)
    }  # fmt: skip
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"patch test"})
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2-lagrange", "q1-fbar")

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job of a single load step."""
        angle = np.radians(self.turn)
        push = {"ux": float(DEPTH * np.sin(angle)), "uy": float(-DEPTH * np.cos(angle))}
        mesh = {"use": "rectangle", "x": [0.0, 1.0]}
        body = {"material": "m", "rotate": self.turn}
        upper, lower = self.upper * setup.level, self.lower * setup.level
        return (
            static_job(
                "pressed", setup, {"m": {"young": YOUNG, "poisson": 0.0}},
                {
                    "upper": body | {"mesh": mesh | {"y": [0.5, 1.0], "cells": [upper, 3]}},
                    "lower": body | {"mesh": mesh | {"y": [0.0, 0.5], "cells": [lower, 3]}},
                },
                {"slave": "upper.bottom", "master": "lower.top"},
                supports=[{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top"} | push],
                fields=True,
                tolerance=1e-12,
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Allow round-off; an algorithm that does not pass gets its error reported."""
        why = "uniform stress is in the space of every element: only round-off of a solve is left"
        exact = (error(name, 1e-10, why, codes=("kept-overlap", "patch-test")) for name in ("displacement", "stress"))
        return *exact, reported("iterations")

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Largest errors of stresses and pressures over the largest exact values."""
        record, angle = only(done), np.radians(self.turn)
        axis = np.array([-np.sin(angle), np.cos(angle)])
        exact = -DEPTH * (record.nodes @ axis)[:, None] * axis
        pressed = -YOUNG * DEPTH * np.outer(axis, axis)
        stress = np.concatenate([values.reshape(-1, 4) for values in record.stress.values()])
        wanted = np.array([pressed[0, 0], pressed[1, 1], 0.0, pressed[0, 1]])
        return {
            "displacement": float(np.abs(record.displacement - exact).max()) / DEPTH,
            "stress": float(np.abs(stress - wanted).max()) / (YOUNG * DEPTH),
            "iterations": iterations(record),
        }
