"""Two leaves clamped side by side, the longer one loaded at its end: they touch where the shorter one ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import static_job

LENGTH, HEIGHT, YOUNG = 40.0, 1.0, 1000.0  # mm, MPa; nu = 0
FORCE = 1e-4  # N/mm: deflections of a hundredth of the height
CELLS = 45  # along the longer leaf, at level 1: the shorter one does not end at a node of it


@dataclass(frozen=True)
class LeafSpring(Case):
    """`length` of the lower leaf over the upper leaf's; `stiff` modulus of the lower over the upper leaf's.

    Cantilevers: deflections at l = length L agree, P l^2 (3 L - l)/6 - F l^3/3 = F l^3/(3 stiff).
    """

    length: float = 0.75
    stiff: float = 1.0

    title: ClassVar[str] = "two leaves that touch at the tip of the shorter"
    source: ClassVar[str] = "Timoshenko, Strength of Materials I, 1930: beams"
    family: ClassVar[str] = "beams"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"length": (0.5, 0.75), "stiff": (0.1, 1.0, 10.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "quadratic edges"})
    proves: ClassVar[frozenset[str]] = frozenset({"resultant"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q2", "q2-lagrange")

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run; cells of the leaves differ in length."""
        n, end = CELLS * setup.level, self.length * LENGTH
        upper = {"use": "rectangle", "x": [0.0, LENGTH], "y": [0.0, HEIGHT], "cells": [n, 1]}
        lower = {
            "use": "rectangle",
            "x": [0.0, end],
            "y": [-HEIGHT, 0.0],
            "cells": [2 * round(0.35 * n * self.length), 1],
        }
        half = round(0.5 * self.length * n) * LENGTH / n
        moduli = {"upper": YOUNG, "lower": YOUNG * self.stiff}
        bodies = {
            "upper": {"material": "upper", "mesh": upper, "sets": {"near": {"of": "bottom", "x": [half, LENGTH]}}},
            "lower": {"material": "lower", "mesh": lower, "sets": {"near": {"of": "top", "x": [0.5 * end, end]}}},
        }
        return (
            static_job(
                "loaded", setup, {name: {"young": young, "poisson": 0.0} for name, young in moduli.items()}, bodies,
                {"slave": "lower.near", "master": "upper.near"},
                supports=[{"on": f"{name}.left", "ux": 0.0, "uy": 0.0} for name in moduli],
                loads=[{"on": "upper.right", "ty": {"ramp": "linear", "to": -FORCE / HEIGHT}, "follower": False}],
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The force between the leaves, from the reaction of the lower one."""
        return [
            error("force between the leaves", 0.02, "shear of leaves 30 to 40 times as long as high: a thousandth"),
            error("where it acts over the length", 0.05, "a cell and a half of the lower leaf"),
            reported("force over the load"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with beams."""
        record, part = only(done), self.length
        exact = FORCE * (3.0 - part) / (2.0 * part * (1.0 + 1.0 / self.stiff))
        force = float(record.reaction("lower.left")[1])
        curve = record.curve()
        weight = np.maximum(1e-300, np.asarray(curve.nodal_pressure))
        return {
            "force between the leaves": force / exact - 1.0,
            "where it acts over the length": float((curve.x * weight).sum() / weight.sum()) / (part * LENGTH) - 1.0,
            "force over the load": force / FORCE,
        }
