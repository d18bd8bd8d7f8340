"""Two blocks that overlap a little before the run, or leave a gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, near
from contactlab_cases.dynamics import WORK
from contactlab_cases.series import series, table

TREATED, END = 5e-4, 1e-3  # s: before that the overlap is treated, then the blocks are pressed
YOUNG, PRESSED, SEGMENT = 1000.0, 0.01, 0.25


@dataclass(frozen=True)
class InitialOverlap(Case):
    """`overlap` in segments, ramped or adjusted, and gaps of 1e-12 of a segment, of none, and as wide as the overlap.

    nu = 0, so that the exact force is Young's modulus times the shortening over the height: a ramp turns the overlap
    into pressure, an adjustment takes it from the height.
    """

    overlap: float = 0.01

    title: ClassVar[str] = "initial overlap and gap"
    source: ClassVar[str] = "a bar in compression"
    family: ClassVar[str] = "patch"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"overlap": (0.001, 0.01, 0.02)}
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    proves: ClassVar[frozenset[str]] = frozenset({"initial overlap", "patch test"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Five jobs: two treatments of an overlap, and three gaps."""
        wide = self.overlap * SEGMENT
        return (
            self._job("ramped", setup, {"bodies.upper.shift": [0.0, -wide]}),
            self._job(
                "adjusted", setup, {"bodies.upper.shift": [0.0, -wide], "contacts.0.start": {"overlap": "adjust"}}
            ),
            self._gap("touching", setup, 0.0),
            self._gap("hair", setup, 1e-12 * SEGMENT),
            self._gap("apart", setup, wide),
        )

    def _gap(self, name: str, setup: Setup, gap: float) -> Job:
        return self._job(name, setup, {"contacts.0.start": {"overlap": "refuse"}, "bodies.upper.shift": [0.0, gap]})

    def _job(self, name: str, setup: Setup, changes: Mapping[str, Any]) -> Job:
        base = {
            **setup.changes("upper", "lower"), "bodies.upper.mesh.cells": [4 * setup.level, 3 * setup.level],
            "bodies.lower.mesh.cells": [7 * setup.level, 3 * setup.level], "time.end": END,
        }  # fmt: skip
        return Job(
            name, "initial-overlap", {**base, **changes}, (series("time", "kinetic", "force.upper.y"),), work=WORK
        )

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Forces and gaps against exact ones; a slow ramp must not make anything swing."""
        wide, slow = self.overlap * SEGMENT, "vibrations have died to a ten-thousandth"
        return (
            at_most("ramped: largest kinetic energy over that stored later", 1e-6, "a ramp of 40 periods"),
            near("ramped: force in the end", YOUNG * (PRESSED + wide), 1e-3, slow, "N"),
            at_most("adjusted: largest kinetic energy over that stored later", 1e-6, "nothing pushes"),
            near("adjusted: force in the end", YOUNG * PRESSED / (1.0 - wide), 1e-3, slow, "N"),
            at_most("force with a gap of 1e-12 segments against none", 1e-9, "continuity"),
            near("force with a gap as wide", YOUNG * (PRESSED - wide), 1e-3, slow, "N"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Forces on the upper block, and energies before it is pressed."""
        force = {name: float(table(record)["force.upper.y"][-1]) for name, record in done.items()}
        found = {
            "force with a gap of 1e-12 segments against none": abs(force["hair"] / force["touching"] - 1.0),
            "force with a gap as wide": force["apart"],
        }
        for how in ("ramped", "adjusted"):
            rows = table(done[how])
            swung = float(rows["kinetic"][rows["time"] <= TREATED].max())
            stored = float(done[how].summary["balance"]["stored"])
            found[f"{how}: largest kinetic energy over that stored later"] = swung / stored
            found[f"{how}: force in the end"] = force[how]
        return found
