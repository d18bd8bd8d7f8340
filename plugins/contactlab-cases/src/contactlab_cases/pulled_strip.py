"""A thin strip on a rigid floor that is pulled at its end: slip runs in as far as friction needs to hold the pull."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error
from contactlab_cases.circles import only
from contactlab_cases.statics import ordered, static_job

LENGTH, HEIGHT, YOUNG = 20.0, 0.25, 1000.0  # mm, MPa; nu = 0
PRESSURE = 0.01  # MPa
CELLS = 80  # along the strip, at level 1


@dataclass(frozen=True)
class PulledStrip(Case):
    """`mu`; `part` of the length that slips. Slip s = P/(mu q), the end moves by P^2/(2 E h mu q)."""

    mu: float = 0.5
    part: float = 0.5

    title: ClassVar[str] = "strip pulled out of its friction"
    source: ClassVar[str] = "equilibrium of a bar: E h u'' = mu q where it slips"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.1, 0.5), "part": (0.25, 0.5, 0.75)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "stick and slip"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2")
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Pressed from the start, pulled by its end face; held sideways against bending."""
        mesh = {"use": "rectangle", "x": [0.0, LENGTH], "y": [0.0, HEIGHT], "cells": [CELLS * setup.level, 1]}
        pull = self.mu * PRESSURE * self.part * LENGTH / HEIGHT
        return (
            static_job(
                "pulled", setup, {"m": {"young": YOUNG, "poisson": 0.0}}, {"strip": {"material": "m", "mesh": mesh}},
                {"slave": "strip.bottom", "master": "floor", "friction": {"use": "coulomb", "mu": self.mu}},
                steps=4, rigid={"floor": {"line": [[2.0 * LENGTH, 0.0], [-LENGTH, 0.0]]}},
                supports=[{"on": "strip.left", "ux": 0.0}],
                loads=[
                    {"on": "strip.top", "pressure": PRESSURE, "follower": False},
                    {"on": "strip.right", "tx": {"ramp": "linear", "to": pull}, "follower": False},
                ],
                fields=True,
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The strip is a bar but near the end of slip and its loaded face."""
        cell, bending = 1.0 / CELLS / setup.level / self.part, "bending near both ends of slip"
        along = "nodes show it to a cell, shear spreads it over a height"
        return [
            error("length that slips", 2.0 * cell + 0.02, along, codes=("creep",)),
            error("way of the end", 0.03 + cell, "the height over the length that slips", codes=("creep",)),
            error("shear over mu q where it slips, largest difference", 0.05, bending, codes=("creep",)),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the bar."""
        record, length = only(done), self.part * LENGTH
        curve = record.curve()
        x, state, shear = ordered(curve.x, curve.state, curve.shear)
        slipping = x[state == 2]
        inner = (x > LENGTH - 0.8 * length) & (x < LENGTH - 0.2 * length)
        own = np.unique(record.cells["strip"])
        end = own[np.isclose(record.nodes[own, 0], LENGTH)]
        way = float(record.displacement[end, 0].mean())
        return {
            "length that slips": (LENGTH - float(slipping.min(initial=LENGTH))) / length - 1.0,
            "way of the end": way / (0.5 * self.mu * PRESSURE * length**2 / (YOUNG * HEIGHT)) - 1.0,
            "shear over mu q where it slips, largest difference": float(
                np.abs(np.abs(shear[inner]) / (self.mu * PRESSURE) - 1.0).max()
            ),
        }
