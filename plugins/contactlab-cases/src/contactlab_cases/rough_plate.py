"""A plate pressed on a rough plane, against published displacements; and the same with much friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import WORK, iterations, ordered, static_job

PUBLISHED = {0.0: 2.86e-5, 1.25e-3: 2.72e-5, 5e-3: 2.28e-5, 7.5e-3: 1.98e-5, 11.25e-3: 1.50e-5}
"""Tangential displacements [m] at places along the plane, mu = 1."""

ROUND_IN_CIRCLES = 50.0
"""Coefficient from which on the iteration cycles: the problem has several solutions."""


@dataclass(frozen=True)
class RoughPlate(Case):
    """40 x 40 mm, in metres and pascals, pressed from above and harder from the left, symmetry on the right."""

    mu: float = 1.0
    cells: int = 32

    title: ClassVar[str] = "plate on a rough plane (SSNV128)"
    source: ClassVar[str] = "Code_Aster V6.04.128"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.5, 1.0, 2.0, 5.0, 20.0, 1000.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "open, slipping and sticking at once"})
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2")
    swaps: ClassVar[bool] = False
    margin: ClassVar[tuple[str, float] | None] = ("mu", 1000.0)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: the plate pressed and sheared on the rough plane."""
        cells = self.cells * setup.level
        mesh = {"use": "rectangle", "x": [0.0, 0.04], "y": [0.0, 0.04], "cells": [cells, cells]}
        job = (
            static_job(
                "pressed", setup, {"m": {"young": 1.3e11, "poisson": 0.2}},
                {"plate": {"material": "m", "mesh": mesh}},
                {"slave": "plate.bottom", "master": "plane", "friction": {"use": "coulomb", "mu": self.mu}},
                rigid={"plane": {"line": [[0.06, 0.0], [-0.02, 0.0]]}},
                supports=[{"on": "plate.right", "ux": 0.0}],
                loads=[
                    {"on": "plate.top", "pressure": {"ramp": "linear", "to": 5e7}, "follower": False},
                    {"on": "plate.left", "pressure": {"ramp": "linear", "to": 15e7}, "follower": False},
                ],
                fields=True,
            )
        )  # fmt: skip
        # cycles of contact states take long before they are detected
        return (replace(job, work=8 * WORK) if self.ill_posed(setup) else job,)

    def ill_posed(self, setup: Setup) -> str:
        """Return a reason above a coefficient of friction beyond which the solution is not unique."""
        return "with so much friction the solution is not unique" if self.mu >= ROUND_IN_CIRCLES else ""

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Displacements against published ones, which are for mu = 1."""
        published = [error(_at(x), 0.05, "the tolerance of the published test") for x in PUBLISHED]
        return [
            *(published if self.mu == 1.0 else []),
            at_most("cone violation", 1e-8, "Newton's tolerance"),
            reported("open until", "mm"),
            reported("sticks from", "mm"),
            reported("iterations"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Take displacements along the plane, and the three zones of contact."""
        record = only(done)
        own = np.unique(record.cells["plate"])
        height = record.nodes[own, 1]  # contacts that need room begin with the plate lifted
        bottom = own[np.isclose(height, height.min())]
        x, moved = ordered(record.nodes[bottom, 0], record.displacement[bottom, 0])
        curve = record.curve()
        at, state = ordered(curve.x, curve.state)
        return {
            **{_at(place): float(np.interp(place, x, moved)) / exact - 1.0 for place, exact in PUBLISHED.items()},
            "cone violation": float(record.summary["contacts"]["contacts.0"]["cone_violation"]),
            "open until": 1e3 * float(at[state == 0].max(initial=0.0)),
            "sticks from": 1e3 * float(at[state == 1].min(initial=np.inf)),
            "iterations": iterations(record),
        }


def _at(x: float) -> str:
    return f"displacement at {1e3 * x:g} mm"
