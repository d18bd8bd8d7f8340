"""A block that only friction holds, against one whose friction has no bound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, reported
from contactlab_cases.statics import iterations, ordered, static_job

SIZE, CELLS, PRESSURE, HELD = 10.0, 20, 100.0, 0.9


@dataclass(frozen=True)
class PulledBlock(Case):
    """10 x 10 under a pressure of 100, sheared evenly all around so that the plane holds nine tenths of mu P.

    With nu = 0 the stress is uniform and all of the sole sticks; with nu = 0.3 it wants to spread, and its ends slide.
    """

    mu: float = 1.0
    poisson: float = 0.0

    title: ClassVar[str] = "block that only friction holds"
    source: ClassVar[str] = "uniform stress, in equilibrium by hand"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.5, 1.0, 2.0, 5.0), "poisson": (0.0, 0.3)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "rigid modes held by friction"})
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2", "q1-fbar")
    swaps: ClassVar[bool] = False
    margin: ClassVar[tuple[str, float] | None] = ("mu", 100.0)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The block, and the same with a friction of 1e9."""
        return self._job("pulled", setup, self.mu), self._job("unlimited", setup, 1e9)

    def _job(self, name: str, setup: Setup, mu: float) -> Job:
        shear, cells = 100.0 * HELD * self.mu, CELLS * setup.level
        mesh = {"use": "rectangle", "x": [0.0, SIZE], "y": [0.0, SIZE], "cells": [cells, cells]}
        return static_job(
            name, setup, {"m": {"young": 1e5, "poisson": self.poisson}},
            {"block": {"material": "m", "mesh": mesh}},
            {"slave": "block.bottom", "master": "plane", "friction": {"use": "coulomb", "mu": mu}},
            rigid={"plane": {"line": [[20.0, 0.0], [-10.0, 0.0]]}},
            loads=[
                {"on": "block.top", "pressure": _rising(PRESSURE), "shear": _rising(-shear), "follower": False},
                {"on": "block.left", "shear": _rising(shear), "follower": False},
                {"on": "block.right", "shear": _rising(shear), "follower": False},
            ],
            fields=True,
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Sticking nodes do not slip, and reactions follow from equilibrium alone."""
        return (
            at_most("slip of sticking nodes in segments", 1e-9, "round-off of positions"),
            at_most("reactions against unlimited friction", 1e-6, "equilibrium gives both components"),
            reported("sticking nodes"),
            reported("nodal pressures against unlimited friction"),
            reported("iterations"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare displacements and forces with a run under unlimited friction."""
        pulled, free = done["pulled"], done["unlimited"]
        curve, other = pulled.curve(), free.curve()
        bottom = np.isclose(pulled.nodes[:, 1], 0.0) & np.isin(np.arange(len(pulled.nodes)), pulled.cells["block"])
        slip = np.abs(pulled.displacement[bottom, 0])[np.argsort(pulled.nodes[bottom, 0])]
        state = ordered(curve.x, curve.state)[1]
        normal, wanted = (c.nodal_pressure[np.argsort(c.x)] for c in (curve, other))
        pulls, others = (record.reaction("plane") for record in (pulled, free))
        return {
            "slip of sticking nodes in segments": float(slip[state == 1].max(initial=0.0)) * CELLS * setup.level / SIZE,
            "reactions against unlimited friction": float(np.abs(pulls / others - 1.0).max()),
            "sticking nodes": float(np.count_nonzero(state == 1)),
            "nodal pressures against unlimited friction": float(np.abs(normal - wanted).max() / wanted.mean()),
            "iterations": iterations(pulled),
        }


def _rising(to: float) -> dict[str, Any]:
    return {"ramp": "linear", "to": to}
