"""A blunt rigid wedge on a half plane: a pressure that grows as the logarithm towards the apex."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Floats, Job, Measure, Record, Setup, Solution
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import block_mesh, only
from contactlab_cases.measures import ContactLength
from contactlab_cases.statics import ordered, plane_strain, projected, static_job

YOUNG = 70000.0
SIZE = 1.0  # mm: the half plane is four times as wide and deep
WIDTH = 0.02  # mm, half of the contact, about


@dataclass(frozen=True)
class BluntWedge(Case):
    """Pressure under a wedge.

    slope   of its flanks
    offset  of the apex, in cells: 0 is on a node of the half plane
    """

    slope: float = 1e-3
    offset: float = 0.0

    title: ClassVar[str] = "a blunt wedge on a half plane"
    source: ClassVar[str] = "Johnson 1985, Contact Mechanics, 5.2"
    family: ClassVar[str] = "edges"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"slope": (1e-3, 1e-2), "offset": (0.0, 0.25, 0.5)}
    demands: ClassVar[frozenset[str]] = frozenset({"implicit"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: the wedge comes down."""
        h, far = self._cell(setup.level), 0.5 * SIZE
        apex = self.offset * h
        line = [[apex - far, far * self.slope], [apex, 0.0], [apex + far, far * self.slope]]
        # depth of a half plane whose displacement is held at four times SIZE below; the width is measured
        depth = self.slope * WIDTH * (1.0 + np.log(8.0 * SIZE / WIDTH)) * 2.0 / np.pi
        return [static_job(
            "pressed", setup, {"plane": {"young": YOUNG, "poisson": 0.3}},
            {"block": {"material": "plane", "mesh": block_mesh(SIZE, h / SIZE, 0.04)}},
            {"slave": "block.top", "master": "wedge"},
            rigid={"wedge": {"line": line}},
            supports=[{"on": "block.bottom", "ux": 0.0, "uy": float(depth)}],
        )]  # fmt: skip

    def _cell(self, level: int) -> float:
        return 0.1 * WIDTH / level

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Errors of the pressure, and its oscillation where it grows without bound."""
        return [
            at_most(
                "L2 of the pressure over that of the best approximation",
                1.5,
                "the best piecewise linear function on ten cells is off by 9 to 14 %: the logarithm is unbounded",
            ),
            reported("L2 of the pressure"),
            error("half-width", 0.1, "nodes show the end of contact to one cell of ten"),
            at_most(
                "rise of the pressure away from the apex",
                0.03,
                "it falls on both sides of the apex; the best approximation rises by 0.014",
            ),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with p = E* slope/pi acosh(a/|x|) with the a of the measured force P = E* slope a."""
        record, h = only(done), self._cell(setup.level)
        a = self._half_width(record)
        curve = record.curve()
        x, pressure = ordered(curve.x - self.offset * h, curve.pressure)

        def exact(at: Floats) -> Floats:
            return self._pressure(at, a)

        right, left = pressure[x > 1.5 * h], pressure[x < -1.5 * h][::-1]
        rise = max(float(np.diff(side).max(initial=0.0)) for side in (right, left))
        cells = int(np.ceil(2.0 * a / h))
        at = np.linspace(-cells * h, cells * h, 16001)
        wanted, found = exact(at - self.offset * h), np.interp(at - self.offset * h, x, pressure)
        l2 = float(np.sqrt(np.mean((found - wanted) ** 2) / np.mean(wanted**2)))
        best = float(np.sqrt(np.mean((projected(at, wanted, 2 * cells) - wanted) ** 2) / np.mean(wanted**2)))
        return {
            "L2 of the pressure": l2,
            "L2 of the pressure over that of the best approximation": l2 / best,
            "half-width": 0.5 * ContactLength().evaluate(record, "contacts.0", None) / a - 1.0,
            "rise of the pressure away from the apex": rise / float(pressure.max()),
        }

    def exact_pressure(self, setup: Setup, done: Mapping[str, Record]) -> Solution | None:
        """The same, denser to its apex and to its edges."""
        a, h = self._half_width(only(done)), self._cell(setup.level)
        half = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, 2001) ** 2)
        x = a * np.concatenate([-half[:0:-1], half])
        cells = int(np.ceil(2.0 * a / h))
        return Solution(x + self.offset * h, self._pressure(x, a), 0.0, "exact", window=(-cells * h, cells * h))

    def _half_width(self, record: Record) -> float:
        """a [mm] of the measured force P = E* slope a."""
        return float(record.reaction("block.bottom")[1]) / (plane_strain(YOUNG) * self.slope)

    def _pressure(self, at: Floats, a: float) -> Floats:
        """p = E* slope/pi acosh(a/|x|) [MPa], x from the apex."""
        inside = np.clip(np.abs(at) / a, 1e-6, 1.0)
        return np.asarray(plane_strain(YOUNG) * self.slope / np.pi * np.arccosh(1.0 / inside))
